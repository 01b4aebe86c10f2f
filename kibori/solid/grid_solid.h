// SPDX-License-Identifier: MIT
// A shape that is given by one number at the centre of each voxel of a grid. A point is inside if
// the trilinear interpolation of the numbers is above 0. The grid's axes are parallel to the
// lattice's. Therefore, the interpolation is linear along a ray between two layers of voxels.
#pragma once

#include <kibori/geometry/label_volume.h>
#include <kibori/geometry/lattice.h>
#include <kibori/solid/interval_solid.h>

namespace kibori {

class GridSolid final : public IntervalSolid {
 public:
  // `corner_mm` is the grid's lower corner, half a voxel below the centre of the first voxel.
  // `shape` must outlive this object.
  GridSolid(const ShapeGrid& shape, const Vec3& corner_mm, const Lattice& lattice);

  LatticeBox bounds() const override { return bounds_; }

 private:
  void fill(const RayTile& rays, TileIntervals& all) const override;

  const ShapeGrid& shape_;
  Vec3 per_node_;   // voxels per lattice unit
  Vec3 at_origin_;  // the lattice's origin, in voxels from the centre of the first voxel
  LatticeBox bounds_;
};

}  // namespace kibori
