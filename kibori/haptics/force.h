// SPDX-License-Identifier: MIT
// Force models: from what a motion removed to force and moment at the tool's tip. Units: N, N mm.
//
//   paper    F = -Kf K p/|p|          M = sum z_i x F_i; the paper's eqs. 4 and 5, to the letter
//   energy   F = -u dV/|p| p/|p|      M likewise; u [N/mm^2] the material's specific cutting energy
//
// p is the tip's displacement over the tick and e_z the tool's axis at its end. Five degrees of
// freedom (eq. 5) keep only the lever along the tool; six keep the whole lever r_i x F_i.
#pragma once

#include <algorithm>

#include <kibori/base/names.h>
#include <kibori/edit/removed.h>
#include <kibori/geometry/material.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// series: what pushes the tool is felt, a spring between hand and tool (motion/spring_tool.h);
// energy and paper: the laws above.
enum class ForceModel { series, energy, paper };
constexpr Names<3> names_of(ForceModel) { return {"series", "energy", "paper"}; }

struct Wrench {
  Vec3 force = Vec3::Zero();   // N
  Vec3 moment = Vec3::Zero();  // N mm about the tip
};

// One tick of a tool's motion, in mm and the world's frame.
struct Tick {
  Vec3 tip = Vec3::Zero();     // at the end
  Vec3 axis = Vec3::UnitZ();   // at the end, unit, from the tip into the body
  Vec3 travel = Vec3::Zero();  // p: displacement of the tip
  Vec3 turn = Vec3::Zero();    // rotation vector [rad]; zero when the tool only shifts
};

// Of the force of a cut, what the hand bears where a motor turns the tool: the motor gives the
// cutting speed, the hand the feed, and feed forces of routers and burrs are of the order of a
// tenth of what a knife of the same chip would need. More, and a ball burr in oak is harder to push
// than a carver can; less, and hard and soft wood feel alike.
inline constexpr double kPoweredShare = 0.1;
// The same where a press or an arbor drives a stamp in, by its lever and screw.
inline constexpr double kPressShare = 0.01;

struct ForceLaw {
  // With `series` a tick has the wrench of `energy`, and the spring's pull stands in for it.
  ForceModel model = ForceModel::paper;
  int dof = 5;  // 5 or 6
  // Model `energy`: of the cut's force, what the hand bears (see kPoweredShare).
  double hand_share = 1;
  // Whether what the tool stands in where a stroke begins resists its first tick, too: so strokes
  // of old documents were felt.
  bool start_resists = false;
};

// The wrench that `removed` causes. `removed` must have its moments about tick.tip
// (Motion::reference), and, while turning, its element sums (Motion::turning). `material(i)` gives
// the properties of material i.
template <class Materials>
Wrench wrench(const ForceLaw& law, const Removed& removed, const Tick& tick, double pitch_mm,
              const Vec3& origin_mm, const Materials& materials);

// Material i of a list that is not empty; one that is not in it is as the last, so that no file of
// somebody's can ask beyond it.
template <class Materials>
const auto& material_of(const Materials& materials, int i) {
  return materials[std::min(static_cast<size_t>(i), std::size(materials) - 1)];
}

// The part of one material: see wrench.
Wrench part_wrench(const ForceLaw& law, const RemovedPart& part, const Material& material,
                   const Tick& tick, double pitch_mm, const Vec3& origin_mm);

template <class Materials>
Wrench wrench(const ForceLaw& law, const Removed& removed, const Tick& tick, double pitch_mm,
              const Vec3& origin_mm, const Materials& materials) {
  Wrench sum;
  removed.for_parts([&](int i, const RemovedPart& part) {
    const Wrench one = part_wrench(law, part, material_of(materials, i), tick, pitch_mm, origin_mm);
    sum.force += one.force;
    sum.moment += one.moment;
  });
  return sum;
}

}  // namespace kibori
