// SPDX-License-Identifier: MIT
// Result of one tick of a tool, for both DirectTool and SpringTool.
#pragma once

#include <cstdint>

#include <kibori/geometry/vec.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/mode.h>
#include <kibori/motion/substeps.h>

namespace kibori {

struct ToolTick {
  // Of the tool: position of its tip at the end, displacement and turn.
  TickMotion motion;
  Pose pose;  // of the tool, at the end
  // [N, N mm about the tip] DirectTool: on the tool. SpringTool: on the hand.
  Wrench wrench;
  Vec3 stretch_mm = Vec3::Zero();  // SpringTool: stretch that results in the wrench (see pull_of)
  double removed_mm3 = 0;          // negative: deposited
  // Lattice nodes that were removed or added: K of force model `paper`.
  int64_t points = 0;
  bool edited = false;    // the path was cut or filled; a replay must do the same
  bool touching = false;  // SpringTool: material holds the tool back
  bool cutting = false;   // SpringTool: material was cut
  // SpringTool: the tool is inside material and waits to be pulled out.
  bool inside = false;
  bool clipped = false;  // a deposit reached beyond the lattice
  double pressure = 1;   // of a pen, 0 to 1: input of ReshapeStroke
};

// Tick in which the tool only moves, and ends exactly at `tip_mm`.
inline ToolTick moved_tick(const ToolMotion& motion, const Vec3& tip_mm) {
  ToolTick tick;
  tick.pose = motion.at(1);
  tick.pose.tip = tip_mm;
  tick.motion = {tip_mm, tick.pose.axis(), motion.travel_mm,
                 motion.turns() ? motion.turn_rad : Vec3(Vec3::Zero())};
  return tick;
}

}  // namespace kibori
