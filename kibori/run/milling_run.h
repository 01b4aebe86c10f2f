// SPDX-License-Identifier: MIT
// Executes canonical moves on a model. A MillRun keeps the state of the machine, cuts the sweeps of
// the tool in batches, and sums what each sweep removes or touches. Internal: not installed.
//
//   act(move)       ─► follow() ─► sweep() ─► add() ─► flush() ─► account()
//   milling_run.cpp    milling_path.cpp                milling_sums.cpp
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <kibori/edit/batch.h>
#include <kibori/mill/arc.h>
#include <kibori/mill/canon_move.h>
#include <kibori/mill/program.h>
#include <kibori/run/milling.h>
#include <kibori/run/milling_clock.h>
#include <kibori/solid/tool.h>

namespace kibori {

class MillRun {
 public:
  MillRun(TriDexel& model, MillOptions options);

  // Puts MillOptions::tool into the spindle. Errors: the tool is not in the table.
  Status begin();
  // Begins a program. The next moves belong to it. `name` is the name of its file.
  void begin_program(const std::string& name);
  // Runs a whole program file.
  Status run(const std::filesystem::path& program);
  // Executes one move.
  Status step(const CanonMove& move);
  // Adds a tool, or replaces the tool with the same number. Puts the tool into the spindle.
  Status set_tool(const MillTool& tool);
  // Moves the machine to a position without a path.
  void put(const AxisPosition& at);
  const AxisPosition& at() const { return at_; }
  size_t program() const { return program_; }  // index of the program
  // Returns the pose of the tool in the frame of the programs.
  Pose pose() const { return options_.machine.pose(at_, tcp_); }
  void add_warnings(const std::vector<ProgramWarning>& warnings);
  // Cuts all pending sweeps. If `complete` is true, also ends the last tool and the last line.
  void end(bool complete);
  // Returns the collisions of all sweeps that are already cut.
  const std::vector<MillCollision>& collisions() const { return summary_.collisions; }
  // Returns the results of all sweeps that are already cut.
  MillSummary summary() const;

 private:
  // Number of sweeps in a batch. Each sweep takes some kB, so larger batches take more memory.
  // Smaller batches keep fewer threads busy.
  static constexpr size_t kBatchSweeps = 1024;

  // A sweep of the batch, and the line that caused it. The kind `body` is a sweep of a part of the
  // tool above the cutter.
  struct Piece {
    enum class Kind { feed, rapid, body } kind = Kind::feed;
    CollisionKind collision = CollisionKind::rapid;
    size_t program = 0;
    int line = 0, tool_index = 0;
    Pose start;
    Vec3 travel_mm = Vec3::Zero();
    double seconds = 0, time_s = 0, rpm = 0;
    double radius_mm = 0;
    // feed_mm_min is the programmed speed. commanded_share is the time at this speed, divided by
    // `seconds`, which includes the acceleration.
    double commanded_share = 0, feed_mm_min = 0;
    size_t tape_move = 0;  // index in MillOptions::tape
  };
  // The duration of a move. seconds: with acceleration. commanded: at the programmed speed
  // feed_mm_min, without acceleration.
  struct MoveTime {
    double seconds = 0, commanded = 0, feed_mm_min = 0;
  };

  void warn_once(const std::string& text);
  Error error_at(const std::string& text) const;

  Status act(const RapidMove& move);
  Status act(const FeedMove& move);
  Status act(const ArcMove& move);
  Status act(const Dwell& dwell);
  Status act(const ToolSelect& select);
  Status act(const ToolChange& change);
  Status act(const ToolLength& length);
  Status act(const SpindleTurn& spindle);
  Status act(const ProgramStop& stop);
  Status act(const UserCode& code);
  Status act(const Coolant&) { return Ok{}; }
  Status act(const ProgramEnd&) { return Ok{}; }
  Status act(const OperatorMessage&) { return Ok{}; }
  Status check_axes(const AxisPosition& to) const;
  MoveTime feed_time(const FeedRate& feed, double length, double degrees, const Vec3& direction);

  void add_tool(const MillTool& tool);
  Status take_tool(int number, const std::string& by);
  Status need_tool();
  void end_tool();

  // milling_path.cpp
  Status follow(Piece::Kind kind, const AxisPosition& from, const AxisPosition& to,
                const ArcPath* arc, const MoveTime& time);
  Pose pose_at(const AxisPosition& at) const;
  bool is_at(const Pose& pose) const;
  template <class Position>
  int turn_pieces(const Position& position) const;
  template <class Position>
  Vec3 tip(const Position& position, int i, int pieces) const;
  Status sweep(Piece::Kind kind, const Pose& end, bool turns, const MoveTime& time);
  bool passes_stock(const ToolMotion& motion, const Pose& end) const;
  void add(const Tool& shape, const Piece& piece, bool clear);
  void add_body(const ToolSection& section, const Piece& of);
  Status record(const ToolMotion& motion);
  Status record_on_tape(Piece::Kind kind, const ToolMotion& motion, double seconds);
  void end_step();

  // milling_sums.cpp
  void flush();
  void meet_fixtures();
  void cut_target();
  void gouge(const BatchCut& cut, size_t i, const CutSums& sums);
  Vec3 in_program(const Vec3& place) const { return options_.setup.from_world(Pose{place}).tip; }
  BatchOptions batch_options() const;
  double mm3(const CutSums& sums) const;
  bool more_than_grazing(const Piece& piece, const CutSums& sums) const;
  void account(const Piece& piece, const CutSums& sums);
  void add_force(const Piece& piece, const CutSums& sums, double volume, MillToolUse& use);
  void limit_feed(const Piece& piece, const Engagement& engagement,
                  const std::optional<CuttingForce>& force);
  void collide(const Piece& piece, CollisionKind kind, double volume);
  void end_line();

  TriDexel& model_;
  const MillOptions options_;
  const Lattice lattice_;
  const double before_mm3_;  // volume of the stock
  Box whole_;
  MillingClock clock_;
  std::vector<MillTool> tools_;
  std::vector<MillToolUse> uses_;  // one per tool
  std::set<int> used_;
  MillSummary summary_;
  std::set<std::string> warned_;
  int64_t steps_ = 0;

  size_t program_ = 0;
  int line_ = 0;
  AxisPosition at_;
  bool tcp_ = false;
  double rpm_ = 0;
  int tool_ = -1, selected_ = -1;
  bool changed_ = false, no_tool_ = false;
  Pose pose_;  // pose of the tool in the model after the last sweep
  // True if there is no material within the cutter at pose_.
  bool clear_ = false;

  double step_removed_mm3_ = 0;  // volume since the current step of the document began
  size_t tape_move_ = 0;         // index of the last move on the tape

  std::vector<std::optional<SweptTool>> sweeps_;
  std::vector<BatchCut> cuts_;
  std::vector<Piece> pieces_;
  MillLine result_;
};

}  // namespace kibori
