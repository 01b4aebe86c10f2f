// SPDX-License-Identifier: MIT
// A motion that turns, as straight substeps: each shifts without turning, at its middle
// orientation, short enough that no point of the tool strays further than kTurnTolerance from its
// true arc.
#pragma once

#include <kibori/base/result.h>
#include <kibori/dexel/field.h>
#include <kibori/geometry/vec.h>
#include <kibori/solid/tool.h>

namespace kibori {

// From `start`, the tip shifts by travel_mm while the tool turns about it by turn_rad (rotation
// vector).
struct ToolMotion {
  Pose start;
  Vec3 travel_mm = Vec3::Zero();
  Vec3 turn_rad = Vec3::Zero();

  bool turns() const;
  // The pose a share of the way along, 0..1.
  Pose at(double share) const;
  // The same motion, ending a share of the way along.
  ToolMotion part(double share) const { return {start, travel_mm * share, turn_rad * share}; }
  // Where substep i of `substeps` starts, in the orientation it keeps.
  Pose substep(int i, int substeps) const;
};

// How many substeps it takes; infinite where the motion is not finite.
double pieces_needed(const Tool& tool, const ToolMotion& motion, const Lattice& lattice);
// Errors: more substeps than kMaxTurnSubsteps.
Result<int> substeps_of(const Tool& tool, const ToolMotion& motion, const Lattice& lattice);

}  // namespace kibori
