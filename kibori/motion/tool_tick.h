// SPDX-License-Identifier: MIT
// The result of one tick (one period of the servo loop) of a tool. DirectTool and SpringTool return
// it.
#pragma once

#include <cstdint>

#include <kibori/geometry/vec.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/mode.h>
#include <kibori/motion/substeps.h>

namespace kibori {

struct ToolTick {
  // Motion of the tool: position of the tip at the end, displacement, and turn.
  TickMotion motion;
  Pose pose;  // pose of the tool at the end
  // The force [N] and the moment about the tip [N mm]. DirectTool: on the tool. SpringTool: on the
  // hand.
  Wrench wrench;
  Vec3 stretch_mm = Vec3::Zero();  // SpringTool: the stretch that causes the wrench (see pull_of)
  double removed_mm3 = 0;          // negative: added
  // Number of lattice nodes that were removed or added: K of the force model `paper`.
  int64_t points = 0;
  bool edited = false;    // the tick cut, filled or reshaped; a replay must do the same
  bool touching = false;  // SpringTool: material holds the tool back
  bool cutting = false;   // SpringTool: material was cut or deposited
  // SpringTool: the tool is inside material and must first be pulled out.
  bool inside = false;
  bool clipped = false;  // the lattice's border cut material off
  double pressure = 1;   // pressure of a pen, 0 to 1: input of ReshapeStroke
};

// Returns the result of a tick in which the tool only moves. The tip ends exactly at `tip_mm`.
inline ToolTick moved_tick(const ToolMotion& motion, const Vec3& tip_mm) {
  ToolTick tick;
  tick.pose = motion.at(1);
  tick.pose.tip = tip_mm;
  tick.motion = {tip_mm, tick.pose.axis(), motion.travel_mm,
                 motion.turns() ? motion.turn_rad : Vec3(Vec3::Zero())};
  return tick;
}

}  // namespace kibori
