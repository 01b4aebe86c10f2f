// SPDX-License-Identifier: MIT
// What a tool does in one tick, and what comes of it: the same for a DirectTool and a SpringTool.
#pragma once

#include <cstdint>

#include <kibori/geometry/vec.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/mode.h>
#include <kibori/motion/substeps.h>

namespace kibori {

struct ToolTick {
  // Of the tool: where its tip ended, and by how much it moved and turned.
  Tick motion;
  Pose pose;  // of the tool, at the end
  // N, N mm about the tip: DirectTool: on the tool. SpringTool: on the hand.
  Wrench wrench;
  Vec3 stretch_mm = Vec3::Zero();  // SpringTool: of the spring that makes the wrench (see pull_of)
  double removed_mm3 = 0;          // negative: deposited
  // Lattice nodes that were removed or added: K of force model `paper`.
  int64_t points = 0;
  bool edited = false;    // the way was cut or filled: replayed, it must be again
  bool touching = false;  // SpringTool: material holds the tool back
  bool cutting = false;   // SpringTool: material was cut
  // SpringTool: the tool stands in material and waits to be pulled out.
  bool inside = false;
  bool clipped = false;  // a deposit reached beyond the lattice
};

// A tick in which the tool only moves, and ends exactly at `tip_mm`.
inline ToolTick moved_tick(const ToolMotion& motion, const Vec3& tip_mm) {
  ToolTick tick;
  tick.pose = motion.at(1);
  tick.pose.tip = tip_mm;
  tick.motion = {tip_mm, tick.pose.axis(), motion.travel_mm,
                 motion.turns() ? motion.turn_rad : Vec3(Vec3::Zero())};
  return tick;
}

}  // namespace kibori
