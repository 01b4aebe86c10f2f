// SPDX-License-Identifier: MIT
// Solids from a drawn curve that is swept infinitely far along a direction, on both sides. A Prism
// is the inside of a closed outline. A Wall is everything within half a thickness of a curve.
// Projected along the direction, the solid is a plane figure and a ray is a straight line. The
// ray's intervals are between its crossings with the figure.
#pragma once

#include <utility>
#include <vector>

#include <kibori/solid/interval_solid.h>

namespace kibori {

// A side of an outline or of a curve: its corners and the normals there, in the plane across the
// direction [lattice units]. The two normals differ if the side approximates a curved one.
struct OutlineSide {
  Eigen::Vector2d a, b;
  Eigen::Vector2d normal_a, normal_b;  // unit, to the right of a -> b
};

// The plane across a direction: unit vectors with u x v = direction.
struct AcrossPlane {
  Vec3 u, v;
  explicit AcrossPlane(const Vec3& direction);
  Eigen::Vector2d to_plane(const Vec3& p) const { return {u.dot(p), v.dot(p)}; }
};

// Common base of Prism and Wall.
class SweptOutline : public IntervalSolid {
 public:
  LatticeBox bounds() const override;

 protected:
  SweptOutline(const AcrossPlane& plane, std::vector<OutlineSide> sides)
      : plane_(plane), sides_(std::move(sides)) {}

  AcrossPlane plane_;
  std::vector<OutlineSide> sides_;
};

class Prism final : public SweptOutline {
 public:
  // `outline`: its sides in order, counter-clockwise, closed, without self-intersection. `within`:
  // the box of interest. Ends outside it may be missing or wrong.
  Prism(const AcrossPlane& plane, std::vector<OutlineSide> outline, const LatticeBox& within);

 private:
  void fill(const RayTile& rays, TileIntervals& all) const override;

  LatticeBox within_;
};

class Wall final : public SweptOutline {
 public:
  // `thickness` in lattice units, more than 0. The ends of an open curve are round.
  Wall(const AcrossPlane& plane, std::vector<OutlineSide> curve, double thickness);

 private:
  void fill(const RayTile& rays, TileIntervals& all) const override;

  double half_;
};

}  // namespace kibori
