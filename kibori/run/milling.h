// SPDX-License-Identifier: MIT
// Runs programs of a milling machine on a stock. Moves become sweeps of the tool. They are cut in
// batches on all cores.
//
//   Program ─► CanonMove ─► Machine::pose ─► straight pieces ─► SweptTool ─► cut_batch ─► sums
//
// By default, the model and the programs have the same coordinates: those of the part's frame
// (mill/canon_move.h). MillOptions::setup places the frame of the programs elsewhere in the model.
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

// A block, or the path of a mesh file or of a document. The stock of a document is the model at its
// head.
using MillStock = std::variant<Box, std::filesystem::path>;

struct MillStockOptions {
  double pitch_mm = 0.5;
  uint8_t material = 0;
  int threads = 1;
  // Bounds of fixtures and target in the model [mm]. The lattice also contains this box.
  std::optional<Box> holds;
  std::function<void(const std::string&)> warning;  // one sentence per call
};

// Makes the model of a stock. A document keeps its own lattice. Errors: those of make_lattice,
// check_memory and of reading the file; a document whose lattice does not hold `holds`.
Result<std::unique_ptr<TriDexel>> make_mill_stock(const MillStock& stock,
                                                  const MillStockOptions& options);

// Material that a line of the program removes from the target.
struct MillGouge {
  size_t program = 0;  // index
  int line = 0, tool = 0;
  double time_s = 0;             // since the start, when the first sweep begins
  Vec3 place_mm = Vec3::Zero();  // centroid of the material, in the program's coordinates
  double volume_mm3 = 0;
};

// Result of one line of a program, within the lattice of the stock.
struct MillLine {
  size_t program = 0;
  int line = 0, tool = 0;
  double path_mm = 0, seconds = 0, removed_mm3 = 0;
  Engagement engagement;  // of the piece that removes the largest section
  CuttingForce force;     // largest of the line; 0 if it is unknown
  // The next three are set if the line cuts and MillOptions::feed_limits is given.
  // Largest factor of the feed rate that keeps force and power within the limits.
  std::optional<double> feed_factor;
  double feed_mm_min = 0;      // feed rate of the program
  bool force_unknown = false;  // the force of a part of the line is unknown
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
  int64_t more_collisions = 0;  // beyond kMaxCollisions
  // Lines that remove material of the target, in order. By rounding, lines that follow its surface
  // also remove a little of it. compare_with_target leaves them out.
  std::vector<MillGouge> gouges;
  int64_t more_gouges = 0;  // beyond kMaxGouges
  std::vector<MillWarning> warnings;
  uint64_t state_hash = 0;
};

// Maximum number of collisions that a summary lists.
inline constexpr size_t kMaxCollisions = 1000;
inline constexpr size_t kMaxGouges = 100000;

struct MillOptions {
  ToolTable tools;
  Machine machine;
  Pose setup;               // the frame of the programs, in the coordinates of the model
  std::string name;         // of the set-up, for labels of steps; may be empty
  std::optional<int> tool;  // in the spindle at the start
  int threads = 1;          // does not change the result
  bool z_only = false;      // edit only the z field
  // Used for forces. If its chip law has different values along the axes, their mean is used.
  Material material;
  bool forces = false;                    // compute engagement and forces
  std::optional<FeedLimits> feed_limits;  // for MillLine::feed_factor; needs forces
  // Models on the lattice of the stock; null: none. A part of the tool that touches a fixture is a
  // collision. Material that the programs remove from the target is a gouge. After the run,
  // `target` is what is left of the target.
  TriDexel* fixtures = nullptr;
  TriDexel* target = nullptr;
  // Stores every move; null: none. Each program and each tool change begins a step. A tick is a
  // move or a piece of one. z_only must be false. After an error, the document holds the moves
  // before it.
  MillDocument* document = nullptr;
  // Keeps every sweep and its results, for playback; null: none. Needs all fields.
  MillTape* tape = nullptr;
  // If it becomes true during the run, the run ends with an error. Null: none.
  const std::atomic<bool>* stop = nullptr;
  // Called for each line whose cutter moves within the lattice, in order. Null: no call. The run
  // does not keep these results, so a long program needs no memory for them.
  std::function<void(const MillLine&)> line;
  // Called at each tool change and at the end, if the tool before it has moved. The model then
  // holds all moves so far. Null: no call.
  std::function<void(const TriDexel&, const MillToolUse&)> tool_done;
  std::function<void(size_t program, int line)> progress;  // about every 1000 lines
};

// Runs the programs in order. A program begins with the tool and the position at the end of the one
// before. Errors: those of the programs; a tool that is not in the table; an axis that the machine
// does not have; a document that cannot be created. Each is one sentence.
Result<MillSummary> run_milling(TriDexel& model, const std::vector<std::filesystem::path>& programs,
                                const MillOptions& options);

}  // namespace kibori
