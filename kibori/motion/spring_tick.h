// SPDX-License-Identifier: MIT
// One tick of a SpringTool while it is solved. The sources of spring_tool.h share it. Internal: not
// installed.
//
//   spring_tool.cpp       a tick from its beginning to its end
//   spring_balance.cpp    what the tool would reach, what resists, and where the spring balances it
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
// If the tool already overlaps by such a rounding error, it touches if it would reach this much
// more. So it does not sink, and it can be pulled out.
inline constexpr double kMoreVolume = 0.01;
// Shortest distance [cells] that is tried. Shorter distances count as rest. Over this distance,
// rounding resists at most like the faces of a few cells.
inline constexpr double kMinStep = 0.01;
// Resistance is a mean over at least this distance [cells]. Rays that graze a wall next to a
// slightly oblique path enter all at once. Over a shorter distance the tool would stick and slip.
inline constexpr double kWindow = 0.25;
inline constexpr int kMaxTrials = 24;
// Limit of one tick, for a tool far behind a hand of limited strength. The tick looks ahead this
// distance [cells] and this number of substeps of its turn. The limit is twice the hand's own
// motion, if that is larger. This bounds the work of a tick. With a smaller one the tool follows
// quick hands late. With a larger one a tool that a wall holds needs more than a tick.
inline constexpr double kLookDistance = 64, kLookSubsteps = 12;
}  // namespace spring

// One straight path (and turn) of the tool within a tick. The solver tries shares of it.
struct SpringTool::Tick {
  const Tool& tool;
  ToolMotion motion;
  double length;  // [mm], turn included
  Mode mode;
  uint8_t material;  // of a deposit
  const std::vector<Material>& materials;
  double inside = 0;       // [cells^3] material inside the tool at the start
  double wall_inside = 0;  // the same for the protected region
  bool clear = false;      // no material inside the tool at the start, in the orientation it keeps.
  // Rest of the path, from its end to the hand, if the hand is farther than a tick looks: the
  // displacement [mm], and its length including the turn.
  Vec3 rest_mm = Vec3::Zero();
  double beyond = 0;
  bool whole = true;           // the path leads to the hand
  bool walled = false;         // the path follows the protected region
  Vec3 target = Vec3::Zero();  // [mm] end of the whole path
  double reach = 0;            // [mm] of the tool
  // Factor by which each material resists more than its u along this path. Bit i of `known`: the
  // factor of material i is computed.
  mutable uint64_t known = 0;
  mutable std::array<double, kMaxMaterials> grained{};
  // Shape of the chip, computed only if earlier cuts provide none.
  mutable bool shape_known = false;
  mutable Chip shape{};

  // The same for every share of the path, so that the reached volumes can be compared.
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
