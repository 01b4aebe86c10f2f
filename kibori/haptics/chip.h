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
// f is the direction of the fibres, f' its part normal to p. kA cuts through end grain. kB works
// along the fibres. kC works across them, with the edge parallel to them (Kivimaa 1950). This is
// Kienzle's law. With m = 0 and one k it is F = k S.
//
// The chip can consist of separate patches with a gap between them. Take two strips whose gap is a
// share g of the whole width. The variance gives sqrt(1 + g + g^2)/(1 - g) times their width. So w
// is divided by that factor.
//
// All quantities are moments of the volume that was removed over the window of path_mean.h.
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
  double front = 0;                  // RemovedPart::ChipSums
  Vec3 front_normal = Vec3::Zero();
  double section = 0;  // of dV/|s|, times the path of the tick [cells]
  double length = 0;   // RemovedPart::ChipSums

  void add(const ChipMoments& other, double times);
};

struct Chip {
  double section_mm2 = 0, width_mm = 0, thickness_mm = 0;
  // 1: the tool moves. 0: it mostly spins in place, and directions have no meaning.
  double moves = 0;
  Vec3 direction = Vec3::Zero();  // p, unit
  Mat3 flatness = Mat3::Zero();   // D
  // Mean normal of the tool's front, its part normal to p. A worn edge is pushed against it.
  Vec3 front = Vec3::Zero();
};

// Computes the shape of the chip that was removed over `cells` of path. `gaps`: share of empty
// cells between the first and the last non-empty cell, along x, y and z. All zero if nothing was
// removed.
Chip chip_of(const ChipMoments& sums, double cells, double pitch_mm,
             const Vec3& gaps = Vec3::Zero());

// The same shape with another section. It keeps the width, unless it would be thicker than wide.
Chip with_section(const Chip& shape, double section_mm2);

// k w tau(t)/S [N/mm^2], which replaces u. `fibre`: direction of the fibres, unit; null: unknown,
// and k is the mean of the three directions. A material without this law returns its u.
double cutting_energy(const Material& material, const Chip& chip, const Vec3* fibre);

// tau of the thickness [mm].
double thickness_factor(double thickness_mm, double m);

}  // namespace kibori
