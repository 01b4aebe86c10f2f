// SPDX-License-Identifier: MIT
// A closed mesh as a tool, swept along a straight line: the mesh at its start, and the prism that
// each triangle sweeps. Exact and not convex. Costs its triangles, and for each tile those that can
// come to its rays; it allocates.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <kibori/geometry/mesh.h>
#include <kibori/solid/interval_solid.h>

namespace kibori {

class SweptMesh final : public IntervalSolid {
 public:
  // `mesh` in tool coordinates [mm], `start` in the world; its frame may be left-handed, which is
  // the mesh mirrored. Rays beyond the lattice may be left out.
  SweptMesh(std::shared_ptr<const TriangleMesh> mesh, const Pose& start,
            const LatticeVector& motion, const Lattice& lattice);

  LatticeBox bounds() const override { return {bounds_}; }

 private:
  // Which triangles can come to which tile of one field's rays.
  struct Bins {
    int u = 0, v = 0, across = 0, down = 0;  // tiles: the first, and how many
    std::vector<uint32_t> first;             // in `triangles`, of each tile, and the end
    std::vector<uint32_t> triangles;
    std::vector<std::array<double, 4>> rects;  // swept_rect of every triangle
  };

  // What a triangle and its prism are, whichever rays look at it.
  struct Face {
    Vec3 normal;          // as long as twice its area
    double along_motion;  // of the normal
    double edge_on;       // below that a ray sees its prism edge-on
    Vec3 edge_normal[3];  // in its plane, into the triangle
    double edge_along_motion[3];
    Vec3 side[3];  // normals of the prism's sides
  };

  void fill(const RayTile& rays, TileIntervals& all) const override;
  // The corners of a triangle, counter-clockwise as seen from outside.
  std::array<const Vec3*, 3> corners_of(uint32_t triangle) const;
  Face face_of(uint32_t triangle) const;
  void sort_into(Bins& bins, Axis axis, const Lattice& lattice) const;
  // The rectangle that a triangle sweeps across the rays: low and high u, low and high v.
  std::array<double, 4> swept_rect(uint32_t triangle, Axis axis) const;

  std::shared_ptr<const TriangleMesh> mesh_;
  bool mirrored_;
  std::vector<Vec3> points_;  // lattice units, at the start
  std::vector<Face> faces_;
  Vec3 motion_;
  Box bounds_, lattice_;
  std::array<Bins, 3> bins_;
};

}  // namespace kibori
