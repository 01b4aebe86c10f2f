// SPDX-License-Identifier: MIT
// The moves of a milling run with their results, and the model between them. A player
// (milling_player.h) goes to any time of the run, while the run still continues.
//
//   MillRun ─► add, cut, press, collide ─► keep ─┬─► moves up to now   ─► MillPlayer
//              (one thread)                      └─► a snapshot        ─► (another thread)
//
// keep() publishes moves together with the snapshot after them, so a reader sees finished moves
// only. Snapshots share memory with the model. If there are too many, every second one is dropped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/names.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/mill/machining.h>
#include <kibori/mill/tool_table.h>
#include <kibori/motion/substeps.h>

namespace kibori {

// The kind of a collision. rapid: a rapid move through material. neck, shank, holder: this part of
// the tool moves through material. fixture: any part of the tool touches a fixture.
enum class CollisionKind { rapid, neck, shank, holder, fixture };
constexpr Names<5> names_of(CollisionKind) {
  return {"rapid", "neck", "shank", "holder", "fixture"};
}

// One collision contains all pieces of a line with the same kind.
struct MillCollision {
  CollisionKind kind = CollisionKind::rapid;
  size_t program = 0;  // index
  int line = 0, tool = 0;
  double time_s = 0;  // since the start, when the first piece begins
  // Lower end of the colliding part at the end of the first piece, in the program's coordinates.
  Vec3 place_mm = Vec3::Zero();
  double volume_mm3 = 0;  // of the material or the fixture in the path
};

// A straight or turning sweep of the tool. An arc has several.
struct MillTapeMove {
  ToolMotion motion;  // in the model
  int program = 0;    // index
  int line = 0;
  int tool = -1;       // index of MillTape::tools(); -1: the spindle is empty
  bool rapid = false;  // else it feeds
  bool clear = false;  // the tool holds no material at the start
  // Time of playback. A move without a feed rate gets a time here, too.
  double start_s = 0, seconds = 0;
  double removed_mm3 = 0, force_n = 0, power_w = 0;  // the largest force; 0 if it is unknown

  double end_s() const { return start_s + seconds; }
};

// Maximum number of moves. They take about 400 MB.
inline constexpr size_t kMaxTapeMoves = 2000000;

class MillTape {
 public:
  // ---- The thread of the run.
  void begin_run();  // programs of one set-up
  void begin_program() { programs_++; }
  int tool_index(const MillTool& tool);
  // Adds a move with the times of the machine. Returns its index. Its times of playback begin where
  // the move before it ends.
  size_t add(MillTapeMove move);
  // Results of a move since the last keep().
  void cut(size_t move, double removed_mm3) { pending(move).removed_mm3 += removed_mm3; }
  void press(size_t move, const CuttingForce& force);
  // The next of the run's collisions begins with this move.
  void collide(size_t move) { collision_moves_.push_back(move); }
  // True if keep() should be called soon.
  bool due() const { return added_ - kept_ >= interval_; }
  // Publishes the moves. `model` holds them. `collisions`: all of this run.
  void keep(const TriDexel& model, const std::vector<MillCollision>& collisions);
  // The first snapshot. Call it before the first move.
  void begin(const TriDexel& model);
  // Nothing is added any more. `error`: a sentence, or empty.
  void finish(const std::string& error);

  // ---- Any thread.
  struct Collision {
    MillCollision met;
    size_t move = 0;  // index of the first one
  };
  struct State {
    size_t moves = 0;       // published
    double seconds = 0;     // of playback
    size_t collisions = 0;  // number of them
    bool done = false;
    std::string error;
  };
  State state() const;
  // A copy of published moves. Returns fewer if there are fewer.
  std::vector<MillTapeMove> moves(size_t from, size_t count) const;
  std::vector<Collision> collisions() const;
  // Index of the first collision whose move ends after a time; nullopt: none.
  std::optional<Collision> collision_after(double seconds) const;
  // Index of the move at a time: the first one that ends after it, or the number of moves.
  size_t move_at(double seconds) const;
  // The moves around `move` that have its program and line: [first, last + 1).
  struct Range {
    size_t begin = 0, end = 0;
  };
  Range line_of(size_t move) const;
  // The moves of the first time that this line, or the next one that moves, is executed. nullopt: no
  // published move.
  std::optional<Range> find_line(int program, int line) const;
  // A snapshot after the first `moves` moves.
  struct Key {
    size_t moves = 0;
    Snapshot model;
  };
  // The latest one of at most this many moves.
  Key key_before(size_t moves) const;
  LatticeBox material_bounds() const;
  MillTool tool(int index) const;
  // The largest force [N] and power [W] in equal parts of the time so far.
  struct Curve {
    double seconds = 0;
    std::vector<float> force_n, power_w;
  };
  Curve curve(size_t parts) const;

 private:
  // Moves between two snapshots, at the beginning. Their replay takes a moment.
  static constexpr size_t kFirstInterval = 256;
  // Maximum number of snapshots, and of bytes of the model with all of them.
  static constexpr size_t kMaxKeys = 256;
  static constexpr size_t kMaxBytes = size_t{1} << 31;
  // If a program gives no feed rate, playback moves this fast [mm/s].
  static constexpr double kUnknownSpeed = 20;

  MillTapeMove& pending(size_t move) { return pending_[move - kept_]; }
  void thin_out(const TriDexel& model);

  // The thread of the run.
  std::vector<MillTapeMove> pending_;
  std::vector<size_t> collision_moves_;  // of this run
  size_t added_ = 0, kept_ = 0, interval_ = kFirstInterval;
  int programs_ = 0, first_program_ = 0;
  size_t first_collision_ = 0, first_tool_ = 0;  // of this run
  double time_s_ = 0;                            // end of the last move
  double machine_s_ = 0;                         // the same, of the machine

  mutable std::mutex mutex_;  // guards the following
  std::deque<MillTapeMove> moves_;
  std::vector<Collision> collisions_;
  std::vector<Key> keys_;
  std::vector<MillTool> tools_;
  LatticeBox bounds_;
  bool done_ = false;
  std::string error_;
};

}  // namespace kibori
