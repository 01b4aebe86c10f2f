// SPDX-License-Identifier: MIT
// The law of cutting forces: force from the section, width, thickness and direction of the chip.
//
//   F = k w tau(t)                  tau(t) = t^(1-m) up to 1 mm; beyond, its tangent
//   S = dV/|p|                      the engaged section [mm^2]
//   w = sqrt(12 lambda_1), t = S/w  width and mean thickness [mm]; lambda_1 >= lambda_2 are the
//                                   eigenvalues of the covariance of the removed volume, projected
//                                   on the plane normal to the motion p
//   k = kB (f.p)^2 + (kA + kC)/2 |f'|^2 + (kC - kA)/2 f'.D f'
//   D = 2 (Sigma - tr Sigma/2 P)/tr Sigma
//
// f is the direction of the fibres, f' its part normal to p. P is the projection on that plane, and
// Sigma the projected covariance. kA is the k of a cut through end grain, kB of a cut along the
// fibres. kC is that of a cut across the fibres, with the edge parallel to them (Kivimaa 1950). Up
// to 1 mm, F is Kienzle's law. With m = 0 and the same k for all directions, F = k S.
//
// The chip can consist of two strips with a gap between them. Let g be the gap's share of the whole
// width. Then w is too large by the factor sqrt(1 + g + g^2)/(1 - g), and is divided by it.
//
// All quantities are computed from moments of the volume removed in the window of path_mean.h.
#pragma once

#include <array>

#include <kibori/geometry/material.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// Sums over the removed volume, in lattice units, with moments about the tip. They are additive.
struct ChipMoments {
  double volume = 0;
  Vec3 first = Vec3::Zero();
  std::array<double, 6> second{};    // xx, yy, zz, xy, xz, yz
  Vec3 displacement = Vec3::Zero();  // of s dV; s is an element's displacement in the tick
  double path = 0;                   // of |s| dV
  double front = 0;                  // see RemovedPart::ChipSums
  Vec3 front_normal = Vec3::Zero();
  double section = 0;  // of dV/|s|, times the path of the tick [cells]
  double length = 0;   // see RemovedPart::ChipSums

  void add(const ChipMoments& other, double times);
};

struct Chip {
  double section_mm2 = 0, width_mm = 0, thickness_mm = 0;
  // 1: the tool moves. 0: it mostly spins in place, and `direction` has no meaning.
  double moves = 0;
  Vec3 direction = Vec3::Zero();  // p, unit
  Mat3 flatness = Mat3::Zero();   // D
  // Part of the front's mean normal that is normal to p. The thrust acts against it.
  Vec3 front = Vec3::Zero();
};

// Computes the shape of the chip that was removed over `cells` of path. `gaps`: share of empty
// cells between the first and the last non-empty cell, along x, y and z. Returns an empty chip if
// nothing was removed.
Chip chip_of(const ChipMoments& sums, double cells, double pitch_mm,
             const Vec3& gaps = Vec3::Zero());

// Returns `shape` with another section. Keeps the width, unless the chip would be thicker than
// wide: then the width grows.
Chip with_section(const Chip& shape, double section_mm2);

// Returns k w tau(t)/S [N/mm^2], which replaces the material's u. `fibre`: unit direction of the
// fibres; null: unknown, then k is the mean of kA, kB and kC. For a material without k, returns u.
double cutting_energy(const Material& material, const Chip& chip, const Vec3* fibre);

// The function tau of the law above.
double thickness_factor(double thickness_mm, double m);

}  // namespace kibori
