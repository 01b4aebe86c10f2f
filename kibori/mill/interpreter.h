// SPDX-License-Identifier: MIT
// Executes G-code: keeps the modal state, and turns lines into canonical moves.
//
//   text ─► parse_gcode ─► Interpreter::run ─► CanonMove, ...
//
// It follows LinuxCNC where it supports a code. docs/milling.md lists the codes and the
// differences. It knows no tools, no stock and no machine.
#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/mill/canon_move.h>
#include <kibori/mill/gcode_parser.h>

namespace kibori {

struct GcodeBlock;

// Values that are stored in the controller and not in the program.
struct InterpreterOptions {
  // Offsets of G54 .. G59.3 in the part's frame: those of G54 are zero.
  std::array<AxisPosition, 9> work_offsets = {};
  // Place of the machine's zero in the part's frame. Without it, moves to places of the machine are
  // marked as unknown.
  std::optional<AxisPosition> machine_zero;
  // Places of G28 and G30 relative to the machine's zero.
  AxisPosition home, second_home;
  // M-codes that the machine knows, in addition to the standard ones. They cause no warning.
  std::vector<int> machine_codes;
};

// A request of the program that has no effect or is unclear.
struct ProgramWarning {
  int line = 0;
  std::string text;
};

class Interpreter {
 public:
  explicit Interpreter(InterpreterOptions options = {}) : options_(std::move(options)) {}

  // Executes one line and appends its moves. Errors: one sentence without file and line. After an
  // error, the interpreter must not be used any more.
  Status run(const GcodeLine& line, int number, std::vector<CanonMove>& out);
  // Sets the current position in the part's frame. Appends no move.
  void set_position(const AxisPosition& at) {
    at_ = at;
    known_.fill(Known::yes);
  }
  // True after M2, M30 or the second %.
  bool ended() const { return ended_; }
  // Each kind of warning appears once, with its first line.
  const std::vector<ProgramWarning>& warnings() const { return warnings_; }
  // True if lengths are in inches at the moment.
  bool inches() const { return inches_; }

 private:
  // What is known about the coordinate of an axis: its value, nothing (at the start), or only that
  // it is relative to the machine's unknown zero.
  enum class Known { yes, start, machine };
  struct Cycle {
    std::optional<double> bottom, clear, step, dwell;  // Z, R, Q [mm]; P [s]
    double from_mm = 0;                                // height at which the series of cycles began
  };

  void add(CanonAction action) { out_->push_back({line_, std::move(action)}); }
  void warn_once(const std::string& key, const std::string& text);
  double scale() const { return inches_ ? 25.4 : 1; }
  double offset(int axis) const;
  double& at(int axis) { return axis < 3 ? at_.xyz_mm[axis] : at_.abc_deg[axis - 3]; }

  Status run_block(const GcodeBlock& block);
  void report_unused(const GcodeBlock& block);
  Status set_speeds(const GcodeBlock& block);
  Status set_tool(const GcodeBlock& block);
  void set_spindle_and_coolant(const GcodeBlock& block);
  Status dwell(const GcodeBlock& block);
  void set_modes(const GcodeBlock& block);
  Status set_length(const GcodeBlock& block);
  Status non_modal(const GcodeBlock& block);
  void go_home(const GcodeBlock& block, const AxisPosition& home);
  Status shift_origin(const GcodeBlock& block);
  Status move(const GcodeBlock& block);
  Result<AxisPosition> target(const GcodeBlock& block);
  Status straight(const GcodeBlock& block, bool feed);
  Status arc(const GcodeBlock& block);
  Result<Vec3> centre_by_radius(const GcodeBlock& block, const AxisPosition& to, bool ccw) const;
  Result<Vec3> centre_by_offset(const GcodeBlock& block, const AxisPosition& to) const;
  void stop(const GcodeBlock& block);

  // canned_cycle.cpp
  Status cycle(const GcodeBlock& block);
  Status read_cycle(const GcodeBlock& block, bool first);
  void drill(const AxisPosition& to, double clear, double bottom, double retract);
  void peck(double clear, double bottom);
  void go_to(double height, bool feed);

  // Moves the tool in straight lines, and stores its position.
  void rapid_to(const AxisPosition& to);
  void feed_to(const AxisPosition& to);
  // Prepares a feed move: replaces unknown coordinates of its start.
  void start_feed(const AxisPosition& to);

  InterpreterOptions options_;
  std::vector<CanonMove>* out_ = nullptr;  // during run
  int line_ = 0;
  bool ended_ = false, in_percent_ = false, any_line_ = false;
  std::vector<ProgramWarning> warnings_;
  std::set<std::string> warned_;

  AxisPosition at_;  // in the part's frame
  std::array<Known, 3> known_ = {Known::start, Known::start, Known::start};
  AxisPosition origin_shift_, stored_shift_;  // G92
  int work_ = 0;                              // index of the work coordinate system
  int motion_ = kNoMotion;
  ArcPlane plane_ = ArcPlane::xy;
  bool inches_ = false, incremental_ = false, arcs_absolute_ = false, retract_to_clear_ = false;
  FeedRate feed_;
  double rpm_ = 0;
  int direction_ = 0, selected_ = -1, tool_ = -1;
  Coolant coolant_;
  Cycle cycle_;

  static constexpr int kNoMotion = 800;  // G80
};

}  // namespace kibori
