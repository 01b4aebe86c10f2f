// SPDX-License-Identifier: MIT
// One tick of a SpringTool while it is solved: shared by the sources of spring_tool.h. Internal:
// not installed.
//
//   spring_tool.cpp       a tick from its beginning to its end
//   spring_balance.cpp    what the tool would reach, what resists, and where the spring balances it
//   spring_strength.cpp   a hand of limited strength: depth gives way before the path does; blows
//   spring_contact.cpp    touching: the surface's normal, sliding, walls that are not cut
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <kibori/motion/spring_tool.h>

namespace kibori {
namespace spring {

// The tool touches where it would reach more than this volume [cells^3] and this area [cells^2]
// over the way there. Less is rounding: where a ray grazes the tool, float32 tells its end to a
// hundredth of a cell.
inline constexpr double kTouchVolume = 0.1, kTouchArea = 0.02;
// Where it stands in such rounding already, it touches if it would reach this much more: so it does
// not sink, and can be pulled out.
inline constexpr double kMoreVolume = 0.01;
// The shortest way [cells] that is tried: shorter ones count as rest. Over it, rounding resists
// like a few cells' faces at most.
inline constexpr double kMinStep = 0.01;
// Resistance is a mean over at least this way [cells]: rays that graze a wall beside a slightly
// oblique way come in all at once, and over less the tool would stick and slip on them.
inline constexpr double kWindow = 0.25;
inline constexpr int kMaxTrials = 24;
// A tool that hangs far behind a hand of a strength looks no farther along in a tick than this way
// [cells], and no more pieces of its turn, or twice what the hand itself did in the tick: so the
// work of a tick has a bound. Smaller, and quick hands are followed late; larger, and a tool that a
// wall holds takes longer than a tick.
inline constexpr double kLookWay = 64, kLookSubsteps = 12;
// A tool whose farthest point goes by its turn so many times as far as by its shift (squared)
// mostly turns: then all fields count alike. Below that the shift's direction tells which rays
// carry no ripple: a blade that turns a little in every tick of a bend would shake by as much as
// its force.
inline constexpr double kMostlyTurns = 16;

}  // namespace spring

// One straight way (and turn) of the tool within a tick, tried at shares of it.
struct SpringTool::Tick {
  const Tool& tool;
  ToolMotion motion;
  double length;  // [mm], turn included
  Mode mode;
  uint8_t material;  // of a deposit
  const std::vector<Material>& materials;
  double inside = 0;       // [cells^3] what the tool stands in at the start
  double wall_inside = 0;  // and of what is not cut
  bool clear = false;      // the tool stands in nothing at the start, in the frame it keeps
  // From the way's end to the hand, where that is farther than a tick looks: as a way [mm], and its
  // length with the turn.
  Vec3 rest_mm = Vec3::Zero();
  double beyond = 0;
  bool whole = true;           // the way leads to the hand
  bool walled = false;         // the way is led along what is not cut
  Vec3 target = Vec3::Zero();  // [mm] where all of the way leads
  double reach2 = 0;           // [mm^2] of the tool
  // How much more than its u each material resists here, and that way, as far as it is known.
  mutable uint64_t known = 0;
  mutable std::array<double, kMaxMaterials> grained{};

  // What each field counts: the motion's direction cosines squared, see haptics/force.h. At any
  // share of the way the same, so that what is reached can be compared.
  Vec3 weights() const {
    const double length2 = motion.travel_mm.squaredNorm();
    if (!(length2 > 0) || motion.turn_rad.squaredNorm() * reach2 > spring::kMostlyTurns * length2)
      return Vec3::Constant(1.0 / 3);
    return motion.travel_mm.cwiseAbs2() / length2;
  }
  double volume(const RemovedPart& part) const {
    const Vec3 weight = weights();
    double sum = 0;
    for (int i = 0; i < 3; i++) sum += weight[i] * part.volume[static_cast<size_t>(i)];
    return sum;
  }
  // The same, as much as each bit of it resists over its material's u.
  double resisting(const RemovedPart& part) const {
    const Vec3 weight = weights();
    double sum = 0;
    for (int i = 0; i < 3; i++) sum += weight[i] * part.resisting(static_cast<size_t>(i));
    return std::max(0.0, sum);
  }
  // About the tip at the way's end.
  Vec3 moment(const RemovedPart& part) const {
    const Vec3 weight = weights();
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 3; i++) sum += weight[i] * part.moment[static_cast<size_t>(i)];
    return sum;
  }
};

// At one share of the way: what would be reached, and what resists.
struct SpringTool::Resistance {
  double reached = 0;  // [cells^3]
  bool touching = false;
  double room = 0;      // [mm^3] that may still be reached before it touches; negative: it touches
  double force = 0;     // N
  bool walled = false;  // it touches what is not cut
};

}  // namespace kibori
