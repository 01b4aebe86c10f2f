// SPDX-License-Identifier: MIT
// Runs programs of a milling machine on a stock: moves become sweeps of the tool, and these are cut
// in batches on all cores.
//
//   Program ─► CanonMove ─► Machine::pose ─► straight pieces ─► SweptTool ─► cut_batch ─► sums
//
// Coordinates of the model are those of the part's frame (mill/canon_move.h).
#pragma once

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
#include <kibori/mill/tool_table.h>

namespace kibori {

// A block, or a file: a mesh, or a document with its result.
using MillStock = std::variant<Box, std::filesystem::path>;

struct MillStockOptions {
  double pitch_mm = 0.5;
  uint8_t material = 0;
  int threads = 1;
  // The lattice holds this box, too [mm]: of fixtures and of the target.
  std::optional<Box> holds;
  std::function<void(const std::string&)> warning;  // one sentence per call
};

// Makes the model of a stock. A document keeps its own lattice. Errors: those of make_lattice,
// check_memory and of reading the file; a document whose lattice does not hold `holds`.
Result<std::unique_ptr<TriDexel>> make_mill_stock(const MillStock& stock,
                                                  const MillStockOptions& options);

// The kind of a collision: a rapid move or a part of the tool in material, or a touched fixture.
enum class CollisionKind { rapid, neck, shank, holder, fixture };
constexpr Names<5> names_of(CollisionKind) {
  return {"rapid", "neck", "shank", "holder", "fixture"};
}

// Pieces of one line with the same kind are one collision.
struct MillCollision {
  CollisionKind kind = CollisionKind::rapid;
  size_t program = 0;  // index
  int line = 0, tool = 0;
  double time_s = 0;             // since the start, of the first piece
  Vec3 place_mm = Vec3::Zero();  // of the tip, at the end of the first piece
  double volume_mm3 = 0;         // of the material that it met
};

// What a line removes from the target.
struct MillGouge {
  size_t program = 0;  // index
  int line = 0, tool = 0;
  double time_s = 0;             // since the start, of the first sweep
  Vec3 place_mm = Vec3::Zero();  // middle of what is removed
  double volume_mm3 = 0;
};

// Result of one line of a program.
struct MillLine {
  size_t program = 0;
  int line = 0, tool = 0;
  double path_mm = 0, seconds = 0, removed_mm3 = 0;
  Engagement engagement;  // of the piece that removes the largest section
  CuttingForce force;     // largest of the line; 0 if it is unknown
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
  std::vector<std::string> programs;
  std::vector<MillToolUse> tools;
  std::vector<MillCollision> collisions;
  int64_t more_collisions = 0;  // beyond kMaxCollisions
  // Lines that remove material of the target, in order. Lines that follow its surface remove a
  // little of it by rounding, too: milling_target.h sorts them out.
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
  std::optional<int> tool;  // in the spindle at the start
  int threads = 1;          // does not change the result
  bool z_only = false;      // edits the z field only
  // For forces. Its chip law is used with the mean of its directions.
  Material material;
  bool forces = false;  // compute engagement and forces
  // Models on the lattice of the stock; null: none. No part of the tool may touch the fixtures.
  // What the programs remove from the target is a gouge. It holds the rest afterwards.
  TriDexel* fixtures = nullptr;
  TriDexel* target = nullptr;
  // Called for each line that moves, in order; null: no call. Needs no memory for long programs.
  std::function<void(const MillLine&)> line;
  // Called at each tool change and at the end, with the tool that has worked until then. The model
  // then holds all moves so far. Null: no call.
  std::function<void(const TriDexel&, const MillToolUse&)> tool_done;
  std::function<void(size_t program, int line)> progress;  // now and then
};

// Runs the programs in order; they share tool and position. Errors: one sentence: those of the
// programs, a tool that is not in the table, an axis that the machine does not have.
Result<MillSummary> run_milling(TriDexel& model, const std::vector<std::filesystem::path>& programs,
                                const MillOptions& options);

}  // namespace kibori
