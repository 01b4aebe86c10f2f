// SPDX-License-Identifier: MIT
// Forces on fingers that hold the control points of a spline. When finger j moves by p_j, the
// shape's surface sweeps through a volume dV_j. The material resists with the work u dV_j. The
// force on the finger is this work divided by |p_j|. It acts against p_j. n is the surface's
// normal; curve.h describes B_j.
//
//   dV_j = integral of B_j |p_j . n| dA        F_j = -u dV_j / |p_j| in the direction of p_j
#pragma once

#include <vector>

#include <kibori/spline/spline_shape.h>

namespace kibori {

// The change of the shape's volume by the displacement of one control point.
struct SplineVolumeChange {
  double net_mm3 = 0;    // gain minus loss of volume, to first order
  double moved_mm3 = 0;  // gain plus loss of volume: dV_j
};

// Returns, for each control point, the effect of its displacement [mm] since the last update. It is
// computed to first order, as if the other points did not move. `displacements_mm` has one entry
// for each control point. The whole surface of the shape counts, even where the model has no
// material.
std::vector<SplineVolumeChange> spline_volume_changes(const SplineMesh& shape,
                                                      const std::vector<Vec3>& displacements_mm);

// Returns the force [N] on each finger. `u` is the specific cutting energy of the material
// [N/mm^2]. If a finger does not move, its force is zero.
std::vector<Vec3> spline_forces(const SplineMesh& shape, const std::vector<Vec3>& displacements_mm,
                                double u);

}  // namespace kibori
