// SPDX-License-Identifier: MIT
// The moves of a milling run with their results, and snapshots of the model between moves. A player
// (milling_player.h) goes to any time of the run, even while the run continues.
//
//   MillRun ─► add, cut, press, collide ─► keep ─┬─► moves up to now   ─► MillPlayer
//              (one thread)                      └─► a snapshot        ─► (another thread)
//
// keep() publishes moves together with the snapshot after them. So a reader sees only finished
// moves. Snapshots share memory with the model. If there are too many, every second snapshot is
// dropped.
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

// The kind of a collision. rapid: the cutter passes through material in a rapid move. neck, shank,
// holder: this part of the tool passes through material. fixture: a part of the tool touches a
// fixture.
enum class CollisionKind { rapid, neck, shank, holder, fixture };
constexpr Names<5> names_of(CollisionKind) {
  return {"rapid", "neck", "shank", "holder", "fixture"};
}

// A collision. It combines all pieces of one line with the same kind of collision.
struct MillCollision {
  CollisionKind kind = CollisionKind::rapid;
  size_t program = 0;  // index of the program
  int line = 0, tool = 0;
  double time_s = 0;  // start of the first piece, since the start of the run
  // Lower end of the colliding part of the tool at the end of the first piece, in the program's
  // coordinates.
  Vec3 place_mm = Vec3::Zero();
  double volume_mm3 = 0;  // volume of material or fixture in the path
};

// A straight or turning sweep of the tool. An arc has several sweeps.
struct MillTapeMove {
  ToolMotion motion;  // in the coordinates of the model
  int program = 0;    // index of the program
  int line = 0;
  int tool = -1;       // index in MillTape::tools(); -1: the spindle is empty
  bool rapid = false;  // true: rapid move; false: feed move
  bool clear = false;  // true if no material is within the tool at the start
  // Times of playback. Here, a move without a feed rate has a time, too.
  double start_s = 0, seconds = 0;
  double removed_mm3 = 0, force_n = 0, power_w = 0;  // force: the largest one; 0 if unknown

  double end_s() const { return start_s + seconds; }
};

// Maximum number of moves. This many moves take about 400 MB.
inline constexpr size_t kMaxTapeMoves = 2000000;

class MillTape {
 public:
  // ---- Functions for the thread of the run.
  void begin_run();  // begins the programs of a set-up
  void begin_program() { programs_++; }
  int tool_index(const MillTool& tool);
  // Adds a move, with times of the machine. Returns its index. In playback, the move begins where
  // the move before it ends.
  size_t add(MillTapeMove move);
  // Add results to a move that was added since the last keep().
  void cut(size_t move, double removed_mm3) { pending(move).removed_mm3 += removed_mm3; }
  void press(size_t move, const CuttingForce& force);
  // Notes that the next collision of the run begins with this move.
  void collide(size_t move) { collision_moves_.push_back(move); }
  // Returns true if keep() should be called soon.
  bool due() const { return added_ - kept_ >= interval_; }
  // Publishes the added moves. `model` is the state after them. `collisions` has all collisions of
  // this run.
  void keep(const TriDexel& model, const std::vector<MillCollision>& collisions);
  // Stores the first snapshot. Call it before the first move.
  void begin(const TriDexel& model);
  // Call it after the last move. `error` is the error sentence of the run, or empty.
  void finish(const std::string& error);

  // ---- Functions for any thread.
  struct Collision {
    MillCollision met;
    size_t move = 0;  // index of its first move
  };
  struct State {
    size_t moves = 0;       // number of published moves
    double seconds = 0;     // time of playback
    size_t collisions = 0;  // number of collisions
    bool done = false;
    std::string error;
  };
  State state() const;
  // Returns copies of published moves. Returns fewer than `count` if there are fewer.
  std::vector<MillTapeMove> moves(size_t from, size_t count) const;
  std::vector<Collision> collisions() const;
  // Returns the first collision whose move ends after this time, or nullopt.
  std::optional<Collision> collision_after(double seconds) const;
  // Returns the index of the first move that ends after this time, or the number of moves.
  size_t move_at(double seconds) const;
  // The range of the neighbouring moves of `move` with the same program and line: begin <= index <
  // end.
  struct Range {
    size_t begin = 0, end = 0;
  };
  Range line_of(size_t move) const;
  // Returns the moves of the first execution of this line. If the line has no moves, uses the next
  // line that has. Returns nullopt if there is no such published move.
  std::optional<Range> find_line(int program, int line) const;
  // A snapshot after the first `moves` moves.
  struct Key {
    size_t moves = 0;
    Snapshot model;
  };
  // Returns the latest snapshot after at most this number of moves.
  Key key_before(size_t moves) const;
  LatticeBox material_bounds() const;
  MillTool tool(int index) const;
  // The largest force [N] and power [W] in each of several equal parts of the time so far.
  struct Curve {
    double seconds = 0;
    std::vector<float> force_n, power_w;
  };
  Curve curve(size_t parts) const;

 private:
  // Number of moves between two snapshots at the beginning. A player cuts this many moves in a
  // moment.
  static constexpr size_t kFirstInterval = 256;
  // Maximum number of snapshots, and maximum memory of the model with all snapshots [bytes].
  static constexpr size_t kMaxKeys = 256;
  static constexpr size_t kMaxBytes = size_t{1} << 31;
  // Speed of playback if a program gives no feed rate [mm/s].
  static constexpr double kUnknownSpeed = 20;

  MillTapeMove& pending(size_t move) { return pending_[move - kept_]; }
  void thin_out(const TriDexel& model);

  // Members for the thread of the run.
  std::vector<MillTapeMove> pending_;
  std::vector<size_t> collision_moves_;  // of this run
  size_t added_ = 0, kept_ = 0, interval_ = kFirstInterval;
  int programs_ = 0, first_program_ = 0;
  size_t first_collision_ = 0, first_tool_ = 0;  // of this run
  double time_s_ = 0;                            // end of the last move, in time of playback
  double machine_s_ = 0;                         // end of the last move, in time of the machine

  mutable std::mutex mutex_;  // guards the members below
  std::deque<MillTapeMove> moves_;
  std::vector<Collision> collisions_;
  std::vector<Key> keys_;
  std::vector<MillTool> tools_;
  LatticeBox bounds_;
  bool done_ = false;
  std::string error_;
};

}  // namespace kibori
