// SPDX-License-Identifier: MIT
// A milling machine: its rotary axes, its speeds, and the values that its controller stores. It
// converts positions of the axes into a pose of the tool in the part's frame.
//
//   tables turn the part:   machine = T1 R1 T1' T2 R2 T2' part      first = nearest to the machine
//   heads turn the tool:    axis of the tool = R1 R2 z              first = nearest to the machine
//
// With tool centre point control (TCP) on, X Y Z are the tip in the part's frame, for any angles of
// the rotary axes. With TCP off, X Y Z are the positions of the linear axes. At zero angles both
// are equal.
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

// The path of a rapid move: all axes arrive together, or each moves at its own full speed.
enum class RapidPath { straight, dog_leg };
constexpr Names<2> names_of(RapidPath) { return {"straight", "dog-leg"}; }

struct RotaryAxis {
  int axis = 0;  // 0: A about x, 1: B about y, 2: C about z
  // A point on the axis, in the part's frame at zero angles [mm]. For a head: the pivot relative to
  // the tip.
  Vec3 point_mm = Vec3::Zero();
};

struct Machine {
  std::string name;
  std::vector<RotaryAxis> tables, heads;
  bool tcp = false;  // at the start of a program
  // M-codes that switch TCP; -1: none.
  int tcp_on = -1, tcp_off = -1;
  RapidPath rapid_path = RapidPath::straight;
  Vec3 rapid_mm_min = Vec3::Constant(5000);
  double rotary_deg_min = 3600;
  double acceleration_mm_s2 = 500;
  double tool_change_s = 10;
  InterpreterOptions controller;

  // True if the machine can turn this axis.
  bool turns(int axis) const;
  // The points of a rapid move after its start: one if all axes arrive together, otherwise up to
  // three, each where an axis arrives.
  std::vector<AxisPosition> rapid_points(const AxisPosition& from, const AxisPosition& to) const;
  // Time of a rapid move at full speed [s], without acceleration.
  double rapid_seconds(const AxisPosition& from, const AxisPosition& to) const;
  // The tool's pose in the part's frame.
  Pose pose(const AxisPosition& at, bool tcp_is_on) const;
};

// Parses a machine file. Errors: one sentence with file, line and key.
Result<Machine> parse_machine(const std::string& text, const std::string& name);
Result<Machine> read_machine(const std::filesystem::path& path);

}  // namespace kibori
