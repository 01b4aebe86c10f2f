// SPDX-License-Identifier: MIT
// The law of cutting forces. The force F depends on the chip: the material that was removed over
// the last cell of path.
//
//   F = k w tau(t)                  tau(t) = t^(1-m) up to 1 mm; beyond, its tangent
//   S = dV/|p|                      the engaged section [mm^2]
//   w = sqrt(12 lambda_1), t = S/w  width and mean thickness [mm]; lambda_1 >= lambda_2 are the
//                                   eigenvalues of the covariance of the removed volume, projected
//                                   on the plane normal to the motion p
//   k = kB (f.p)^2 + (kA + kC)/2 |f'|^2 + (kC - kA)/2 f'.D f'
//   D = 2 (Sigma - tr Sigma/2 P)/tr Sigma
//
// p is the motion; in the formula of k, it is a unit vector. f is the unit direction of the fibres,
// and f' the part of f normal to p. P is the projection on the plane normal to p, and Sigma the
// projected covariance. kA is k for a cut through end grain. kB is k for a cut along the fibres. kC
// is k for a cut across the fibres with the edge parallel to them (Kivimaa 1950). Up to a thickness
// of 1 mm, F is Kienzle's law. With m = 0 and the same k for all directions, F = k S.
//
// The chip can consist of two strips with a gap between them. Let g be the share of the gap in the
// whole width. Then the formula makes w too large by the factor sqrt(1 + g + g^2)/(1 - g). So w is
// divided by this factor.
//
// All quantities are computed from moments of the volume that was removed in the window of
// path_mean.h.
#pragma once

#include <array>

#include <kibori/geometry/material.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// Sums over the removed volume, in lattice units. Moments are about the tip. Sums of several
// volumes can be added.
struct ChipMoments {
  double volume = 0;
  Vec3 first = Vec3::Zero();
  std::array<double, 6> second{};    // xx, yy, zz, xy, xz, yz
  Vec3 displacement = Vec3::Zero();  // integral of s dV; s: displacement of an element in the tick
  double path = 0;                   // integral of |s| dV
  double front = 0;                  // see RemovedPart::ChipSums
  Vec3 front_normal = Vec3::Zero();
  double section = 0;  // integral of dV/|s|, times the path of the tick [cells]
  double length = 0;   // see RemovedPart::ChipSums

  void add(const ChipMoments& other, double times);
};

struct Chip {
  double section_mm2 = 0, width_mm = 0, thickness_mm = 0;
  // 1 if the tool moves, 0 if it mostly spins in place. At 0, `direction` has no meaning. Between 0
  // and 1, both laws are blended.
  double moves = 0;
  Vec3 direction = Vec3::Zero();  // p, unit vector
  Mat3 flatness = Mat3::Zero();   // D
  // The part of the front's mean normal that is normal to p. The thrust acts against this vector.
  Vec3 front = Vec3::Zero();
};

// Returns the shape of the chip that was removed over `cells` of path. `gaps`: the share of empty
// cells between the first and the last non-empty cell, along x, y and z. Returns an empty chip if
// nothing was removed.
Chip chip_of(const ChipMoments& sums, double cells, double pitch_mm,
             const Vec3& gaps = Vec3::Zero());

// Returns the shape with another section. The width stays, unless the chip would be thicker than
// wide. Then the width grows.
Chip with_section(const Chip& shape, double section_mm2);

// Returns k w tau(t)/S [N/mm^2], which replaces the material's u. `fibre` is the unit direction of
// the fibres. If it is null, k is the mean of kA, kB and kC. If the material has no k, returns its
// u.
double cutting_energy(const Material& material, const Chip& chip, const Vec3* fibre);

// Returns tau of the law above.
double thickness_factor(double thickness_mm, double m);

}  // namespace kibori
