// SPDX-License-Identifier: MIT
// Solids that are made from a plane curve. The curve is swept infinitely far, to both sides of its
// plane. A Prism is the inside of a closed outline. A Wall is everything within half a thickness of
// a curve. The projection of a solid to the plane is a figure, and the projection of a ray is a
// straight line. The ray's intervals are between the crossings of this line with the figure.
#pragma once

#include <utility>
#include <vector>

#include <kibori/solid/interval_solid.h>

namespace kibori {

// One side of an outline or a curve: its two corners, and the normals at the corners, in the plane
// [lattice units]. If the side approximates a part of a smooth curve, its two normals differ.
struct OutlineSide {
  Eigen::Vector2d a, b;
  Eigen::Vector2d normal_a, normal_b;  // unit, to the right of a -> b
};

// The plane perpendicular to a direction. Its unit vectors u and v are such that u x v = direction.
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
  // `outline`: the sides in order, counter-clockwise and closed. They must not cross each other.
  // `within`: the box of interest. Ends outside this box may be missing or wrong.
  Prism(const AcrossPlane& plane, std::vector<OutlineSide> outline, const LatticeBox& within);

 private:
  void fill(const RayTile& rays, TileIntervals& all) const override;

  LatticeBox within_;
};

class Wall final : public SweptOutline {
 public:
  // `thickness` is in lattice units and must be more than 0. The ends of an open curve are round.
  Wall(const AcrossPlane& plane, std::vector<OutlineSide> curve, double thickness);

 private:
  void fill(const RayTile& rays, TileIntervals& all) const override;

  double half_;
};

}  // namespace kibori
