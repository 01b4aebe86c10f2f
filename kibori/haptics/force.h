// SPDX-License-Identifier: MIT
// Force models: compute the force and moment at the tool's tip from the material that a motion
// removed. Units: N, N mm.
//
//   paper    F = -Kf K p/|p|          M = sum z_i x F_i; exactly eqs. 4 and 5 of the paper
//   energy   F = -u dV/|p| p/|p|      M = z x F with the centre of dV; u [N/mm^2] is the material's
//                                     specific cutting energy, or the result of the law of chip.h
//
// p is the tip's displacement over the tick. dV is the sliding mean (path_mean.h) of the removed
// volume. The levers z are relative to the tip. With five degrees of freedom (eq. 5), z is the part
// of the lever along the tool's axis. With six it is the whole lever.
#pragma once

#include <algorithm>

#include <kibori/base/names.h>
#include <kibori/edit/removed.h>
#include <kibori/geometry/material.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/path_mean.h>

namespace kibori {

// series: a spring between hand and tool gives the force (motion/spring_tool.h). energy and paper:
// the laws above.
enum class ForceModel { series, energy, paper };
constexpr Names<3> names_of(ForceModel) { return {"series", "energy", "paper"}; }

struct Wrench {
  Vec3 force = Vec3::Zero();   // N
  Vec3 moment = Vec3::Zero();  // N mm about the tip
};

// One tick of a tool's motion, in mm, in the world's frame.
struct TickMotion {
  Vec3 tip = Vec3::Zero();     // at the end
  Vec3 axis = Vec3::UnitZ();   // at the end, unit, from the tip into the body
  Vec3 travel = Vec3::Zero();  // p: displacement of the tip
  Vec3 turn = Vec3::Zero();    // rotation vector [rad]; zero if the tool only translates
};

// Share of the cutting force that the hand supports if a motor drives the tool: the hand only feeds
// the tool. Feed forces of routers and burrs are about a tenth of the force of a knife with the
// same chip. With a larger share, a carver could not push a ball burr through oak. With a smaller
// one, hard and soft wood would give the same force.
inline constexpr double kPoweredShare = 0.1;
// Share that the hand supports if a press drives a stamp: its lever or screw does the rest.
inline constexpr double kPressShare = 0.01;

// ForceLaw::thrust of a sharp edge, and its maximum. The edge of a worn tool has more thrust.
inline constexpr double kSharpThrust = 0.3, kMaxThrust = 3;

inline constexpr int kForceVersion = 2;

struct ForceLaw {
  // In model `series`, DirectTool computes the wrench as in `energy`; HandTool replaces it by the
  // spring's pull.
  ForceModel model = ForceModel::paper;
  int dof = 5;  // 5 or 6
  // Model `energy`: share of the cutting force that the hand supports (see kPoweredShare).
  double hand_share = 1;
  // True: material inside the tool at the stroke's beginning also resists in the first tick. Old
  // documents computed their forces this way.
  bool start_resists = false;
  // Model `energy`: thrust as a share of the cutting force. It pushes the edge along the normal of
  // its front and does no work.
  double thrust = 0;
  // Version of the code that computed a document's stored forces. 1: volumes as means of the three
  // fields (before November 29, 2026). 2: volumes of dexel/volume.h.
  int version = kForceVersion;
};

// Material i of a list that is not empty. An index beyond the list gives the last material, so that
// a damaged file cannot read out of bounds.
template <class Materials>
const auto& material_of(const Materials& materials, int i) {
  return materials[std::min(static_cast<size_t>(i), std::size(materials) - 1)];
}

// Model `paper`: wrench of the removed points of one material.
Wrench paper_wrench(int dof, const RemovedPart& part, const Material& material,
                    const TickMotion& tick, double pitch_mm, const Vec3& origin_mm);

// Model `energy`: resistance of the removed part of one material. `part` must have moments about
// tick.tip (Motion::reference). For a turn it also needs element sums (Motion::turning).
PathMean::Resistance resistance_of(const RemovedPart& part, const TickMotion& tick,
                                   double pitch_mm);
// Wrench of the resistance that is paid in a tick (see path_mean.h). u: cutting_energy of chip.h.
Wrench energy_wrench(const ForceLaw& law, const PathMean::Resistance& paid, double u,
                     const TickMotion& tick, double pitch_mm);
// Wrench of the thrust if the cutting force is `force`. It acts at the centre of the paid volume.
Wrench thrust_wrench(const ForceLaw& law, const ChipMoments& paid, const Chip& chip,
                     const Vec3& force, const TickMotion& tick, double pitch_mm);

}  // namespace kibori
