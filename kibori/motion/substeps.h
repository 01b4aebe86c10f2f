// SPDX-License-Identifier: MIT
// Divides a motion that turns into straight substeps. In a substep the tool keeps one orientation,
// that of the substep's middle. No point of the tool deviates from its true arc by more than
// kTurnTolerance.
#pragma once

#include <kibori/base/result.h>
#include <kibori/dexel/field.h>
#include <kibori/geometry/vec.h>
#include <kibori/solid/tool.h>

namespace kibori {

// A motion from `start`: the tip moves by travel_mm while the tool turns about it by turn_rad
// (rotation vector).
struct ToolMotion {
  Pose start;
  Vec3 travel_mm = Vec3::Zero();
  Vec3 turn_rad = Vec3::Zero();

  bool turns() const;
  // Pose at a share of the motion, 0..1.
  Pose at(double share) const;
  // The same motion, cut off at a share of it.
  ToolMotion part(double share) const { return {start, travel_mm * share, turn_rad * share}; }
  // Start pose of substep i of `substeps`, in the orientation that the substep keeps.
  Pose substep(int i, int substeps) const;
};

// Number of substeps that the motion needs; infinite if the motion is not finite.
double pieces_needed(const Tool& tool, const ToolMotion& motion, const Lattice& lattice);
// Number of substeps as an integer. Errors: more than kMaxTurnSubsteps.
Result<int> substeps_of(const Tool& tool, const ToolMotion& motion, const Lattice& lattice);

}  // namespace kibori
