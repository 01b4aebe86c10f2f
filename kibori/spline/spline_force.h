// SPDX-License-Identifier: MIT
// Forces on fingers that hold a spline's control points. When a finger moves, the shape's surface
// sweeps through a volume dV. The material resists with the work u dV. The force is this work
// divided by the finger's displacement p. n is the surface's normal; curve.h describes B.
//
//   dV_j = integral of B_j |p_j . n| dA        F_j = -u dV_j / |p_j| in the direction of p_j
#pragma once

#include <vector>

#include <kibori/spline/spline_shape.h>

namespace kibori {

// The change of volume by one control point's displacement.
struct SplineVolumeChange {
  double net_mm3 = 0;    // gain minus loss of the shape's volume, to first order
  double moved_mm3 = 0;  // gain plus loss: dV_j
};

// For each control point: the effect of its displacement [mm] since the last update, to first
// order, as if the others did not move. `displacements_mm` has one entry per control point. The
// whole surface of the shape counts, also where the model has no material.
std::vector<SplineVolumeChange> spline_volume_changes(const SplineMesh& shape,
                                                      const std::vector<Vec3>& displacements_mm);

// The force [N] on each finger. `u`: specific cutting energy of the material [N/mm^2]. A finger
// that does not move has no force.
std::vector<Vec3> spline_forces(const SplineMesh& shape, const std::vector<Vec3>& displacements_mm,
                                double u);

}  // namespace kibori
