// SPDX-License-Identifier: MIT
// A shape given by numbers in the middles of voxels: where their trilinear interpolation is above
// 0. Along a ray of the lattice, that is linear from one layer of voxels to the next.
#pragma once

#include <kibori/geometry/label_volume.h>
#include <kibori/geometry/lattice.h>
#include <kibori/solid/interval_solid.h>

namespace kibori {

class GridSolid final : public IntervalSolid {
 public:
  // The grid's lower corner, half a voxel below the middle of its first, stands at `corner_mm`.
  // `shape` must outlive this.
  GridSolid(const ShapeGrid& shape, const Vec3& corner_mm, const Lattice& lattice);

  LatticeBox bounds() const override { return bounds_; }

 private:
  void fill(const RayTile& rays, TileIntervals& all) const override;

  const ShapeGrid& shape_;
  Vec3 per_node_;   // voxels a lattice unit
  Vec3 at_origin_;  // the lattice's origin, in voxels from the middle of the first
  LatticeBox bounds_;
};

}  // namespace kibori
