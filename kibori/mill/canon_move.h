// SPDX-License-Identifier: MIT
// Canonical moves: the steps of a program after all modes, units and offsets are resolved.
//
// Positions are those of the tool's tip in the part's frame. The part's frame is the work
// coordinate system G54. Lengths are mm, angles of rotary axes are degrees.
#pragma once

#include <string>
#include <variant>

#include <kibori/geometry/vec.h>

namespace kibori {

// The positions of all six axes of a machine.
struct AxisPosition {
  Vec3 xyz_mm = Vec3::Zero();
  Vec3 abc_deg = Vec3::Zero();
  bool operator==(const AxisPosition& other) const {
    return xyz_mm == other.xyz_mm && abc_deg == other.abc_deg;
  }
};

// G93 (inverse time), G94 (per minute), G95 (per revolution).
enum class FeedMode { inverse_time, per_minute, per_revolution };

// The speed of a feed move. The unit of `value` depends on the mode: 1/min, mm/min or deg/min, mm
// per revolution. 0: the program does not give it.
struct FeedRate {
  FeedMode mode = FeedMode::per_minute;
  double value = 0;
  bool operator==(const FeedRate&) const = default;
};

// G17, G18, G19.
enum class ArcPlane { xy, zx, yz };

// Indices of the two axes of an arc's plane, and of the axis normal to it. The three axes, in this
// order, are right-handed.
struct ArcAxes {
  int first, second, normal;
};
constexpr ArcAxes axes_of(ArcPlane plane) {
  switch (plane) {
    case ArcPlane::xy:
      return {0, 1, 2};
    case ArcPlane::zx:
      return {2, 0, 1};
    case ArcPlane::yz:
      return {1, 2, 0};
  }
  return {0, 1, 2};
}

struct RapidMove {
  AxisPosition to;
  // True if the start or the end of the path is unknown in the part's frame. Then the path is not
  // checked for collisions. The start of the first move is unknown. A place of the machine (G28,
  // G30, G53) is unknown if the machine's zero is unknown.
  bool place_unknown = false;
};
struct FeedMove {
  AxisPosition to;
  FeedRate feed;
};
// An arc, a helix or a full circle. The radius may change evenly from the start to the end.
struct ArcMove {
  AxisPosition to;
  ArcPlane plane = ArcPlane::xy;
  Vec3 centre_mm = Vec3::Zero();  // the component along the normal is not used
  // Positive: counter-clockwise, seen against the normal. 1 or -1: up to one full turn. 2 or -2:
  // one turn more, and so on.
  int turns = 1;
  FeedRate feed;
};
struct Dwell {
  double seconds = 0;
};
struct ToolSelect {
  int number = 0;
};
struct ToolChange {
  int number = 0;
};
// G43: number of the tool whose length is used. 0: G49.
struct ToolLength {
  int number = 0;
};
struct SpindleTurn {
  int direction = 0;  // 1: clockwise; -1: counter-clockwise; 0: stop
  double rpm = 0;
};
struct Coolant {
  bool mist = false, flood = false;
};
struct ProgramStop {
  bool optional = false;
};
struct ProgramEnd {};
// An M-code that the interpreter does not know. A machine file may define its meaning.
struct UserCode {
  int number = 0;
};
struct OperatorMessage {
  std::string text;
};

using CanonAction =
    std::variant<RapidMove, FeedMove, ArcMove, Dwell, ToolSelect, ToolChange, ToolLength,
                 SpindleTurn, Coolant, ProgramStop, ProgramEnd, UserCode, OperatorMessage>;

struct CanonMove {
  int line = 0;  // line of the program's file, from 1
  CanonAction action;
};

}  // namespace kibori
