// SPDX-License-Identifier: MIT
// A milling machine: its rotary axes, its speeds, and the values that its controller stores. A
// Machine converts positions of the axes into the pose of the tool in the part's frame.
//
//   tables turn the part:   machine = T1 R1 T1' T2 R2 T2' part      index 1: nearest to the machine
//   heads turn the tool:    axis of the tool = R1 R2 z              index 1: nearest to the machine
//
// X Y Z depend on tool centre point control (TCP). With TCP on, they are the position of the tip in
// the part's frame, for any angles of the rotary axes. With TCP off, they are the positions of the
// linear axes. If all angles are zero, both are equal.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>
#include <kibori/mill/canon_move.h>
#include <kibori/mill/interpreter.h>

namespace kibori {

// The path of a rapid move. straight: all axes arrive at the same time. dog_leg: each axis moves
// with its own full speed.
enum class RapidPath { straight, dog_leg };
constexpr Names<2> names_of(RapidPath) { return {"straight", "dog-leg"}; }

struct RotaryAxis {
  int axis = 0;  // 0: A about x, 1: B about y, 2: C about z
  // A point on the axis, in the part's frame at zero angles [mm]. For a head: the position of the
  // pivot relative to the tip.
  Vec3 point_mm = Vec3::Zero();
};

struct Machine {
  std::string name;
  std::vector<RotaryAxis> tables, heads;
  bool tcp = false;  // state at the start of a program
  // M-codes that switch TCP on and off; -1: none.
  int tcp_on = -1, tcp_off = -1;
  RapidPath rapid_path = RapidPath::straight;
  Vec3 rapid_mm_min = Vec3::Constant(5000);
  double rotary_deg_min = 3600;
  double acceleration_mm_s2 = 500;
  double tool_change_s = 10;
  InterpreterOptions controller;

  // Returns true if the machine can turn this axis.
  bool turns(int axis) const;
  // Returns the points of a rapid move after its start. If all axes arrive at the same time, there
  // is one point. Otherwise, there is one where each axis arrives, at most three.
  std::vector<AxisPosition> rapid_points(const AxisPosition& from, const AxisPosition& to) const;
  // Returns the duration of a rapid move at full speed [s]. Acceleration is ignored.
  double rapid_seconds(const AxisPosition& from, const AxisPosition& to) const;
  // Returns the pose of the tool in the part's frame.
  Pose pose(const AxisPosition& at, bool tcp_is_on) const;
};

// Parse or read a machine file (TOML). Errors: the file cannot be read, or a value is invalid. The
// message has file, line and key.
Result<Machine> parse_machine(const std::string& text, const std::string& name);
Result<Machine> read_machine(const std::filesystem::path& path);

}  // namespace kibori
