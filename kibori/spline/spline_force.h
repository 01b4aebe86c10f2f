// SPDX-License-Identifier: MIT
// What fingers at a spline's control points feel: each the work of the volume that its own motion
// moves the shape's surface through, over its way.
//
//   dV_j = integral of B_j |p_j . n| dA        F_j = -u dV_j / |p_j| in the direction of p_j
#pragma once

#include <vector>

#include <kibori/spline/spline_shape.h>

namespace kibori {

struct SplineVolumeChange {
  double net_mm3 = 0;    // what the shape gains, to first order
  double moved_mm3 = 0;  // what it gains and what it loses: dV_j
};

// What each control point's displacement [mm] since the last update does, alone, to first order in
// the displacement. One displacement for each control point. A revolved surface goes along turned
// about its axis. The shape's own surface counts, wherever the material is.
std::vector<SplineVolumeChange> spline_volume_changes(const SplineMesh& shape,
                                                      const std::vector<Vec3>& displacements_mm);

// The force [N] on each finger, of a material that takes u N/mm^2 (specific cutting energy). A
// finger that does not move feels none.
std::vector<Vec3> spline_forces(const SplineMesh& shape, const std::vector<Vec3>& displacements_mm,
                                double u);

}  // namespace kibori
