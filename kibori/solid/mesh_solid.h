// SPDX-License-Identifier: MIT
// A closed mesh as a tool, swept along a straight line. The sweep is the union of the mesh at
// its start and the prisms that its triangles sweep. It is exact. The mesh need not be convex. The
// time of its construction grows with the number of triangles. The time for a tile grows with the
// number of triangles that can reach it. It allocates memory.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <kibori/geometry/mesh.h>
#include <kibori/solid/interval_solid.h>

namespace kibori {

class SweptMesh final : public IntervalSolid {
 public:
  // `mesh` is in tool coordinates [mm], `start` in the world. The frame may be left-handed, which
  // mirrors the mesh. `spans` may omit rays beyond the lattice.
  SweptMesh(std::shared_ptr<const TriangleMesh> mesh, const Pose& start,
            const LatticeVector& motion, const Lattice& lattice);

  LatticeBox bounds() const override { return {bounds_}; }

 private:
  // The triangles that can reach each tile of one field's rays.
  struct Bins {
    int u = 0, v = 0, across = 0, down = 0;  // tiles: the first, and their number along u and v
    std::vector<uint32_t> first;             // per tile the index into `triangles`, and the end
    std::vector<uint32_t> triangles;
    std::vector<std::array<double, 4>> rects;  // swept_rect of every triangle
  };

  // Values of a triangle and its prism that do not depend on the field.
  struct Face {
    Vec3 normal;          // its length is twice the triangle's area
    double along_motion;  // dot product of normal and motion
    double edge_on;       // below this, a ray sees the prism edge-on
    Vec3 edge_normal[3];  // in the triangle's plane, towards its inside
    double edge_along_motion[3];
    Vec3 side[3];  // normals of the prism's sides
  };

  void fill(const RayTile& rays, TileIntervals& all) const override;
  // The corners of a triangle, counter-clockwise seen from outside.
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
