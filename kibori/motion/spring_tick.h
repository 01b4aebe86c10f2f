// SPDX-License-Identifier: MIT
// The state of a SpringTool while it computes one tick. The sources of spring_tool.h share it.
// Internal: not installed.
//
//   spring_tool.cpp       a tick from its beginning to its end
//   spring_balance.cpp    material that the tool would reach, its resistance, the spring's balance
//   spring_strength.cpp   a hand of limited strength: reduced depth; blows of a mallet
//   spring_contact.cpp    contact: the surface's normal, sliding, walls of the protected region
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <kibori/motion/spring_tool.h>

namespace kibori {
namespace spring {

// The tool touches if it would reach more than this volume [cells^3] plus this area [cells^2] times
// the distance. Smaller overlaps are rounding error: float32 resolves a grazing ray's end to 0.01
// cells.
inline constexpr double kTouchVolume = 0.1, kTouchArea = 0.02;
// The tool may already overlap the material by such a rounding error. Then it touches only if it
// would reach this much more [cells^3]. So it neither sinks in slowly nor sticks.
inline constexpr double kMoreVolume = 0.01;
// Shortest distance [cells] that is tried. If the tool could move less, it rests. With a shorter
// distance, rounding errors of the volume would look like a large resistance.
inline constexpr double kMinStep = 0.01;
// Resistance is a mean over at least this distance [cells] ahead. Rows of rays enter a tool at
// once, many of them if it moves along a wall on a slightly oblique path. With a shorter distance
// the tool would stick and slip. A longer one is smoother. But a tool that is pressed in then meets
// the section at half of this distance below it: with one cell, a light hand did not dent foam.
inline constexpr double kWindow = 0.25;
inline constexpr int kMaxTrials = 24;
// Limit of one tick, for a tool far behind a hand of limited strength. The tick looks ahead this
// distance [cells] and this number of substeps of its turn. The limit is twice the hand's own
// motion, if that is larger. This bounds the work of a tick. With a smaller limit, the tool follows
// quick hands late. With a larger one, a tick of a tool that a wall holds takes longer than the
// time between ticks.
inline constexpr double kLookDistance = 64, kLookSubsteps = 12;
}  // namespace spring

// One straight path (and turn) of the tool within a tick. The solver computes the share of this
// path that the tool moves.
struct SpringTool::Tick {
  const Tool& tool;
  ToolMotion motion;
  double length;  // [mm], turn included
  Mode mode;
  uint8_t material;  // of a deposit
  const std::vector<Material>& materials;
  double inside = 0;       // [cells^3] material inside the tool at the start
  double wall_inside = 0;  // the same for the protected region
  bool clear = false;      // no material inside the tool at the start, in the orientation it keeps
  // Rest of the path, from its end to the hand, if the hand is farther away than kLookDistance or
  // kLookSubsteps allow: the displacement [mm], and its length including the turn.
  Vec3 rest_mm = Vec3::Zero();
  double beyond = 0;
  bool whole = true;            // the path leads to the hand
  bool walled = false;          // the path follows the protected region
  Vec3 target = Vec3::Zero();   // [mm] end of the whole path
  double reach = 0;             // [mm] of the tool
  Vec3 hand_mm = Vec3::Zero();  // the hand's own motion in this tick
  // For each material: its resistance along this path as a factor of its u. Bit i of `known`: the
  // factor of material i is computed.
  mutable uint64_t known = 0;
  mutable std::array<double, kMaxMaterials> grained{};
  // Shape of the chip, computed only if earlier cuts provide none.
  mutable bool shape_known = false;
  mutable Chip shape{};

  // Weights of the rays. They are the same for every share of the path, so that the reached volumes
  // can be compared.
  Vec3 weights() const { return ray_weights(motion, reach); }
};

// Result of a trial at one share of the path: the reached volume and the resistance.
struct SpringTool::Resistance {
  double reached = 0;  // [cells^3]
  bool touching = false;
  double room = 0;      // [mm^3] that may be reached before the tool touches; negative: it touches
  double force = 0;     // N
  bool walled = false;  // it touches the protected region
};

}  // namespace kibori
