// SPDX-License-Identifier: MIT
// Executes G-code. The interpreter keeps the modal state, and converts lines into canonical moves.
//
//   text ─► parse_gcode ─► Interpreter::run ─► CanonMove, ...
//
// For all codes that it supports, the interpreter follows LinuxCNC. docs/milling.md lists the codes
// and the differences. The interpreter does not use tools, the stock or the machine.
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

// Values that the controller of the machine stores. They are not in the program.
struct InterpreterOptions {
  // Offsets of G54 ... G59.3 in the part's frame. Those of G54 are zero.
  std::array<AxisPosition, 9> work_offsets = {};
  // Place of the machine's zero in the part's frame. If it is missing, moves to places of the
  // machine are marked with place_unknown.
  std::optional<AxisPosition> machine_zero;
  // Places of G28 and G30, relative to the machine's zero.
  AxisPosition home, second_home;
  // M-codes of the machine, in addition to the standard ones. They cause no warning.
  std::vector<int> machine_codes;
};

// A warning about a request of the program that has no effect or is unclear.
struct ProgramWarning {
  int line = 0;
  std::string text;
};

class Interpreter {
 public:
  explicit Interpreter(InterpreterOptions options = {}) : options_(std::move(options)) {}

  // Executes one line and appends its moves. `number` is the number of the line. Errors (without
  // file and line): the line is invalid. After an error, the interpreter must not be used any more.
  Status run(const GcodeLine& line, int number, std::vector<CanonMove>& out);
  // Sets the current position in the part's frame, without a move.
  void set_position(const AxisPosition& at) {
    at_ = at;
    known_.fill(Known::yes);
  }
  // Returns true after M2, M30 or the second %.
  bool ended() const { return ended_; }
  // Returns the warnings. Each kind of warning occurs once, with its first line.
  const std::vector<ProgramWarning>& warnings() const { return warnings_; }
  // Returns true if the current unit of lengths is the inch.
  bool inches() const { return inches_; }

 private:
  // What is known about the coordinate of an axis. yes: its value. start: nothing, at the start of
  // the program. machine: only its value relative to the machine's zero, which is unknown.
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

  // Move the tool in straight lines, and store its new position.
  void rapid_to(const AxisPosition& to);
  void feed_to(const AxisPosition& to);
  // Prepares a feed move: replaces the unknown coordinates of its start by those of `to`.
  void start_feed(const AxisPosition& to);

  InterpreterOptions options_;
  std::vector<CanonMove>* out_ = nullptr;  // set during run()
  int line_ = 0;
  bool ended_ = false, in_percent_ = false, any_line_ = false;
  std::vector<ProgramWarning> warnings_;
  std::set<std::string> warned_;

  AxisPosition at_;  // current position in the part's frame
  std::array<Known, 3> known_ = {Known::start, Known::start, Known::start};
  AxisPosition origin_shift_, stored_shift_;  // shift by G92; shift that G92.3 restores
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
