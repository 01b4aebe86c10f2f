// SPDX-License-Identifier: MIT
// What a drawn curve bounds when it is swept without end along a direction: a Prism is the inside
// of a closed outline, a Wall is all within half a thickness of a curve. In the plane across the
// direction every ray is a straight line; its intervals lie between its crossings.
#pragma once

#include <utility>
#include <vector>

#include <kibori/solid/interval_solid.h>

namespace kibori {

// A side of an outline, or of a curve: corners, and the normals there, in the plane across the
// direction (lattice units). The normals differ where the side stands for a curved one.
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

// What Prism and Wall share.
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
  // `outline`: its sides, one after another, counter-clockwise, closed, not crossing itself.
  // `within`: where it is looked at; ends elsewhere are not told from none.
  Prism(const AcrossPlane& plane, std::vector<OutlineSide> outline, const LatticeBox& within);

 private:
  void fill(const RayTile& rays, TileIntervals& all) const override;

  LatticeBox within_;
};

class Wall final : public SweptOutline {
 public:
  // `thickness` in lattice units, more than 0; the ends of an open curve are round.
  Wall(const AcrossPlane& plane, std::vector<OutlineSide> curve, double thickness);

 private:
  void fill(const RayTile& rays, TileIntervals& all) const override;

  double half_;
};

}  // namespace kibori
