// SPDX-License-Identifier: MIT
// Runs programs of a milling machine on a stock. The moves become sweeps of the tool. The sweeps
// are cut in batches on all cores.
//
//   Program ─► CanonMove ─► Machine::pose ─► straight pieces ─► SweptTool ─► cut_batch ─► sums
//
// Usually, the model and the programs have the same coordinates: those of the part's frame
// (mill/canon_move.h). If MillOptions::setup is given, the frame of the programs is placed in the
// model.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/material.h>
#include <kibori/mill/machine.h>
#include <kibori/mill/machining.h>
#include <kibori/mill/refeed.h>
#include <kibori/mill/tool_table.h>
#include <kibori/run/milling_document.h>
#include <kibori/run/milling_tape.h>

namespace kibori {

// A block, or the path of a mesh file or a document. The stock of a document is the model at its
// head.
using MillStock = std::variant<Box, std::filesystem::path>;

struct MillStockOptions {
  double pitch_mm = 0.5;
  uint8_t material = 0;
  int threads = 1;
  // Bounds of the fixtures and of the target in the model [mm]. The lattice must contain this box,
  // too.
  std::optional<Box> holds;
  std::function<void(const std::string&)> warning;  // called with one sentence for each warning
};

// Makes the model of a stock. A document keeps its own lattice. Errors: those of make_lattice and
// check_memory; the file cannot be read; the lattice of the document does not contain `holds`.
Result<std::unique_ptr<TriDexel>> make_mill_stock(const MillStock& stock,
                                                  const MillStockOptions& options);

// A gouge: material of the target that a line of the program removes.
struct MillGouge {
  size_t program = 0;  // index of the program
  int line = 0, tool = 0;
  double time_s = 0;             // start of the first sweep, since the start of the run
  Vec3 place_mm = Vec3::Zero();  // centroid of the material, in the program's coordinates
  double volume_mm3 = 0;
};

// The result of one line of a program, within the lattice of the stock.
struct MillLine {
  size_t program = 0;
  int line = 0, tool = 0;
  double path_mm = 0, seconds = 0, removed_mm3 = 0;
  Engagement engagement;  // of the piece with the largest section
  CuttingForce force;     // the largest one of the line; 0 if unknown
  // Feed limits: the next three members are set if the line cuts and MillOptions::feed_limits is
  // given. feed_factor: the largest factor for the feed rate that keeps force and power within the
  // limits.
  std::optional<double> feed_factor;
  double feed_mm_min = 0;      // programmed feed rate
  bool force_unknown = false;  // true if the force of a part of the line is unknown
};

struct MillToolUse {
  int number = 0;
  std::string name;
  double removed_mm3 = 0, cutting_mm = 0, seconds = 0;
  double max_force_n = 0, max_power_w = 0, max_chip_mm = 0;
  int max_force_line = 0;
};

struct MillWarning {
  size_t program = 0;
  int line = 0;
  std::string text;
};

struct MillSummary {
  double pitch_mm = 0, removed_mm3 = 0, remaining_mm3 = 0;
  double seconds = 0, rapid_seconds = 0, feed_mm = 0, rapid_mm = 0;
  int64_t moves = 0, sweeps = 0;
  Pose setup;  // MillOptions::setup
  std::vector<std::string> programs;
  std::vector<MillToolUse> tools;
  std::vector<MillCollision> collisions;
  int64_t more_collisions = 0;  // number of collisions that are not listed
  // Lines that remove material of the target, in order. Because of rounding, lines that follow the
  // surface of the target also remove a little material. compare_with_target leaves these lines
  // out.
  std::vector<MillGouge> gouges;
  int64_t more_gouges = 0;  // number of gouges that are not listed
  std::vector<MillWarning> warnings;
  uint64_t state_hash = 0;
};

// Maximum numbers of collisions and of gouges that a summary lists.
inline constexpr size_t kMaxCollisions = 1000;
inline constexpr size_t kMaxGouges = 100000;

struct MillOptions {
  ToolTable tools;
  Machine machine;
  Pose setup;               // frame of the programs, in the coordinates of the model
  std::string name;         // name of the set-up, for labels of steps; may be empty
  std::optional<int> tool;  // tool in the spindle at the start
  int threads = 1;          // does not change the result
  bool z_only = false;      // edits only the z field
  // Material for forces. If its chip law has different values along the axes, their mean is used.
  Material material;
  bool forces = false;                    // compute engagement and forces
  std::optional<FeedLimits> feed_limits;  // for MillLine::feed_factor; needs `forces`
  // Models on the lattice of the stock; null: none. A collision occurs if a part of the tool
  // touches a fixture. A gouge occurs if the programs remove material from the target. After the
  // run, `target` is what is left of the target.
  TriDexel* fixtures = nullptr;
  TriDexel* target = nullptr;
  // Stores every move in a document; null: no document. A step begins with each program and each
  // tool change. A tick is a move or a piece of a move. z_only must be false. After an error, the
  // document has the moves before the error.
  MillDocument* document = nullptr;
  // Keeps every sweep with its results, for playback; null: no tape. z_only must be false.
  MillTape* tape = nullptr;
  // If it becomes true during the run, the run ends with an error. It may be null.
  const std::atomic<bool>* stop = nullptr;
  // Called for each line whose cutter moves within the lattice, in order. It may be null. The run
  // does not keep these results, so that a long program needs no memory for them.
  std::function<void(const MillLine&)> line;
  // Called at each tool change and at the end, if the tool has moved. Then the model has all moves
  // so far. It may be null.
  std::function<void(const TriDexel&, const MillToolUse&)> tool_done;
  std::function<void(size_t program, int line)> progress;  // called about every 1000 moves
};

// Runs the programs in order. Each program begins with the tool and the position at the end of the
// program before it. Errors: those of the programs; a tool is not in the table; the machine lacks
// an axis; the document cannot be created; options.stop became true.
Result<MillSummary> run_milling(TriDexel& model, const std::vector<std::filesystem::path>& programs,
                                const MillOptions& options);

}  // namespace kibori
