// SPDX-License-Identifier: MIT
// Forces on fingers at a spline's control points. A finger's motion moves the shape's surface
// through a volume. The force is the work of that volume, divided by the finger's displacement.
//
//   dV_j = integral of B_j |p_j . n| dA        F_j = -u dV_j / |p_j| in the direction of p_j
#pragma once

#include <vector>

#include <kibori/spline/spline_shape.h>

namespace kibori {

// The change of volume by one control point's displacement.
struct SplineVolumeChange {
  double net_mm3 = 0;    // what the shape gains, to first order
  double moved_mm3 = 0;  // what it gains plus what it loses: dV_j
};

// The effect of each control point's displacement [mm] since the last update, alone, to first
// order. `displacements_mm` has one entry per control point. A revolved surface moves with a turn
// about its axis. The shape's own surface counts, also where there is no material.
std::vector<SplineVolumeChange> spline_volume_changes(const SplineMesh& shape,
                                                      const std::vector<Vec3>& displacements_mm);

// The force [N] on each finger. The material needs u N/mm^2 (specific cutting energy). A finger
// that does not move has no force.
std::vector<Vec3> spline_forces(const SplineMesh& shape, const std::vector<Vec3>& displacements_mm,
                                double u);

}  // namespace kibori
