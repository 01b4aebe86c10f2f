// SPDX-License-Identifier: MIT
// A closed mesh as a tool, swept along a straight line: the mesh at its start, and the prism that
// each triangle sweeps. Exact and not convex, so in several layers. For batch work: it keeps its
// own copy of the mesh, and costs triangles x touched tiles.
#pragma once

#include <array>
#include <vector>

#include <kibori/dexel/field.h>
#include <kibori/geometry/mesh.h>
#include <kibori/solid/solid.h>

namespace kibori {

class SweptMesh final : public Solid {
 public:
  // `mesh` in tool coordinates [mm], `start` in the world.
  SweptMesh(const TriangleMesh& mesh, const Pose& start, const LatticeVector& motion,
            const Lattice& lattice);

  LatticeBox bounds() const override { return {bounds_}; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  struct Interval {
    float lo, hi;
    uint32_t normal_lo, normal_hi;
  };
  using TileIntervals = std::array<std::vector<Interval>, kTileRays>;
  // The intervals of every ray of a tile; remembered while the same tile is asked about.
  const TileIntervals& intervals(const RayTile& rays) const;

  std::vector<Vec3> points_;  // lattice units, at the start
  std::vector<std::array<uint32_t, 3>> triangles_;
  Vec3 motion_;
  Box bounds_;
  uint64_t id_;
};

}  // namespace kibori
