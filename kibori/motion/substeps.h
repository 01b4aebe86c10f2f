// SPDX-License-Identifier: MIT
// Divides a motion with a turn into straight substeps. During a substep, the tool keeps the
// orientation of the middle of the substep. No point of the tool leaves its true arc by more than
// kTurnTolerance.
#pragma once

#include <kibori/base/result.h>
#include <kibori/dexel/field.h>
#include <kibori/geometry/vec.h>
#include <kibori/solid/tool.h>

namespace kibori {

// A motion of the tool from the pose `start`. The tip moves by travel_mm. At the same time, the
// tool turns about the tip by turn_rad (rotation vector).
struct ToolMotion {
  Pose start;
  Vec3 travel_mm = Vec3::Zero();
  Vec3 turn_rad = Vec3::Zero();

  bool turns() const;
  // Returns the pose at a share of the motion, 0..1.
  Pose at(double share) const;
  // Returns the first part of the motion, up to a share of it.
  ToolMotion part(double share) const { return {start, travel_mm * share, turn_rad * share}; }
  // Returns the pose at the start of substep i of `substeps`, with the orientation of that substep.
  Pose substep(int i, int substeps) const;
};

// Returns the number of substeps that the motion needs. Infinite if the motion is not finite.
double pieces_needed(const Tool& tool, const ToolMotion& motion, const Lattice& lattice);
// Returns this number as an integer. Errors: the motion needs more than kMaxTurnSubsteps.
Result<int> substeps_of(const Tool& tool, const ToolMotion& motion, const Lattice& lattice);

}  // namespace kibori
