// SPDX-License-Identifier: MIT
// The state of a SpringTool during one tick. The sources of spring_tool.h share it. A trial
// computes what the tool would reach at one share of the tick's path. Internal: not installed.
//
//   spring_tool.cpp       a tick from its beginning to its end
//   spring_balance.cpp    trials: the material that the tool would reach, and its resistance;
//                         the balance of resistance and spring
//   spring_strength.cpp   a hand with limited strength: reduced depth; blows of a mallet
//   spring_contact.cpp    contact: the surface's normal, sliding, walls of the protected region
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <kibori/motion/spring_tool.h>

namespace kibori {
namespace spring {

// The tool touches if the volume that it would reach exceeds kTouchVolume [cells^3] plus kTouchArea
// [cells^2] times the distance. A smaller volume is rounding error, because float32 resolves the
// end of a grazing ray to 0.01 cells.
inline constexpr double kTouchVolume = 0.1, kTouchArea = 0.02;
// The tool may already overlap the material by such a rounding error. Then it touches only if it
// would reach kMoreVolume more [cells^3]. Therefore, it neither sinks in slowly nor sticks.
inline constexpr double kMoreVolume = 0.01;
// Minimum distance of a trial [cells]. If the tool can move less, it rests. At a shorter distance,
// rounding errors of the volume would look like a large resistance.
inline constexpr double kMinStep = 0.01;
// The resistance is a mean over at least this distance ahead [cells]. A tool that moves along a
// wall on a slightly oblique path meets many rays at once. If the distance were shorter, the tool
// would stick and slip. If it were longer, the force would be smoother. But a tool that is pressed
// in meets the section at half of this distance below it. With a distance of one cell, a light hand
// could not dent foam.
inline constexpr double kWindow = 0.25;
inline constexpr int kMaxTrials = 24;
// Limits of one tick, for a tool that is far behind a hand with limited strength. The tick looks
// ahead by at most this distance [cells] and this number of substeps of its turn. If twice the
// hand's motion in the tick is more, that is the limit. The limits bound the work of a tick. If
// they were smaller, the tool would follow quick hands late. If they were larger, a tick could take
// longer than its period while a wall holds the tool.
inline constexpr double kLookDistance = 64, kLookSubsteps = 12;
}  // namespace spring

// One straight path (and turn) of the tool within a tick. The solver computes along which share of
// this path the tool moves.
struct SpringTool::Tick {
  const Tool& tool;
  ToolMotion motion;
  double length;  // length of the path with its turn [mm]
  Mode mode;
  uint8_t material;  // material of a deposit
  const std::vector<Material>& materials;
  double inside = 0;       // material inside the tool at the start [cells^3]
  double wall_inside = 0;  // part of the protected region inside the tool at the start [cells^3]
  bool clear = false;      // true if no material is inside the tool at the start, without a turn
  // If the path is cut off by kLookDistance or kLookSubsteps: the displacement from the end of the
  // path to the hand [mm], and its length with the turn [mm].
  Vec3 rest_mm = Vec3::Zero();
  double beyond = 0;
  bool whole = true;            // true if the path leads to the hand
  bool walled = false;          // true if the path was changed to follow the protected region
  Vec3 target = Vec3::Zero();   // end of the whole path [mm]
  double reach = 0;             // reach of the tool [mm]; 0 without a turn
  Vec3 hand_mm = Vec3::Zero();  // motion of the hand in this tick
  // Cached factor of each material: its resistance along this path, divided by its u. Bit i of
  // `known` is set if the factor of material i is computed.
  mutable uint64_t known = 0;
  mutable std::array<double, kMaxMaterials> grained{};
  // Cached shape of the chip. It is computed only if earlier cuts provide none.
  mutable bool shape_known = false;
  mutable Chip shape{};

  // Returns the weights of the rays. They are the same for every share of the path, so that volumes
  // of different trials can be compared.
  Vec3 weights() const { return ray_weights(motion, reach); }
};

// The result of a trial at one share of the path.
struct SpringTool::Resistance {
  double reached = 0;  // volume that the tool would reach [cells^3]
  bool touching = false;
  // Volume that the tool may still reach before it touches [mm^3]. Negative: it touches.
  double room = 0;
  double force = 0;     // resistance [N]
  bool walled = false;  // true if the tool touches the protected region
};

}  // namespace kibori
