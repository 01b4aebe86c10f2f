// SPDX-License-Identifier: MIT
// Force models. They compute the force F and the moment M at the tool's tip from the material that
// a motion removed. Units: N, N mm.
//
//   paper    F = -Kf K p/|p|          M = sum z_i x F_i; exactly eqs. 4 and 5 of the paper
//   energy   F = -u dV/|p| p/|p|      M = z x F
//
// p is the displacement of the tip in the tick. K is the number of removed lattice nodes, and Kf
// the force of one node. dV is the sliding mean (path_mean.h) of the removed volume. u is the
// specific cutting energy of the material [N/mm^2], or the result of the law of chip.h. A lever z
// points from the tip to a removed node (paper) or to the centre of dV (energy). With five degrees
// of freedom (eq. 5), only the part of the lever along the tool's axis counts.
#pragma once

#include <algorithm>

#include <kibori/base/names.h>
#include <kibori/edit/removed.h>
#include <kibori/geometry/material.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/path_mean.h>

namespace kibori {

// series: the force comes from a spring between hand and tool (motion/spring_tool.h). energy,
// paper: the laws above.
enum class ForceModel { series, energy, paper };
constexpr Names<3> names_of(ForceModel) { return {"series", "energy", "paper"}; }

struct Wrench {
  Vec3 force = Vec3::Zero();   // N
  Vec3 moment = Vec3::Zero();  // N mm about the tip
};

// The motion of a tool in one tick, in mm, in the world's frame.
struct TickMotion {
  Vec3 tip = Vec3::Zero();     // position of the tip at the end
  Vec3 axis = Vec3::UnitZ();   // unit vector from the tip into the tool's body, at the end
  Vec3 travel = Vec3::Zero();  // p: displacement of the tip
  Vec3 turn = Vec3::Zero();    // rotation vector [rad]; zero if the tool only translates
};

// Share of the cutting force that the hand supports if a motor drives the tool. Then the hand only
// feeds the tool. The feed forces of routers and burrs are about a tenth of the force of a knife
// with the same chip. With a larger share, a carver could not push a ball burr through oak. With a
// smaller share, hard and soft wood would give the same force.
inline constexpr double kPoweredShare = 0.1;
// Share of the force that the hand supports if a press drives a stamp. The lever or screw of the
// press supports the rest.
inline constexpr double kPressShare = 0.01;

// ForceLaw::thrust of a sharp edge, and the largest permitted thrust. A worn edge has more thrust.
inline constexpr double kSharpThrust = 0.3, kMaxThrust = 3;

inline constexpr int kForceVersion = 2;

struct ForceLaw {
  // With `series`, DirectTool computes the wrench as with `energy`. HandTool replaces this wrench
  // by the pull of the spring.
  ForceModel model = ForceModel::paper;
  int dof = 5;  // 5 or 6
  // Models `energy` and `series`: share of the cutting force that the hand supports (see
  // kPoweredShare).
  double hand_share = 1;
  // If true, material inside the tool at the stroke's beginning also resists in the first tick. Old
  // documents computed their forces in this way.
  bool start_resists = false;
  // Model `energy`: thrust as a share of the cutting force. The thrust pushes the edge along the
  // normal of the edge's front, and does no work.
  double thrust = 0;
  // Version of the code that computed the forces in a document. 1: volumes as means of the three
  // fields (before November 29, 2026). 2: the volumes of dexel/volume.h.
  int version = kForceVersion;
};

// Returns material i of a list that is not empty. If i is beyond the list, returns the last
// material. So a damaged file cannot cause a read out of bounds.
template <class Materials>
const auto& material_of(const Materials& materials, int i) {
  return materials[std::min(static_cast<size_t>(i), std::size(materials) - 1)];
}

// Model `paper`: returns the wrench of the removed nodes of one material.
Wrench paper_wrench(int dof, const RemovedPart& part, const Material& material,
                    const TickMotion& tick, double pitch_mm, const Vec3& origin_mm);

// Model `energy`: returns the resistance of the removed part of one material. `part` must have
// moments about tick.tip (Motion::reference). If the tool turns, `part` must also have the sums of
// Motion::turning.
PathMean::Resistance resistance_of(const RemovedPart& part, const TickMotion& tick,
                                   double pitch_mm);
// Returns the wrench of the resistance that is paid in a tick (see path_mean.h). `u` is the result
// of cutting_energy() (chip.h).
Wrench energy_wrench(const ForceLaw& law, const PathMean::Resistance& paid, double u,
                     const TickMotion& tick, double pitch_mm);
// Returns the wrench of the thrust for the cutting force `force`. The thrust acts at the centre of
// the paid volume.
Wrench thrust_wrench(const ForceLaw& law, const ChipMoments& paid, const Chip& chip,
                     const Vec3& force, const TickMotion& tick, double pitch_mm);

}  // namespace kibori
