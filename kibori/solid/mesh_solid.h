// SPDX-License-Identifier: MIT
// A closed mesh as a tool, swept along a straight line. The mesh need not be convex. The sweep is
// the union of the mesh at its start and the prisms that its triangles sweep. The result is exact.
// The time of the construction grows with the number of triangles. The time for a tile grows with
// the number of triangles that can reach the tile. The class allocates memory.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <kibori/geometry/mesh.h>
#include <kibori/solid/interval_solid.h>

namespace kibori {

class SweptMesh final : public IntervalSolid {
 public:
  // `mesh` is in tool coordinates [mm]. `start` is the pose of the tool in the world. A left-handed
  // frame mirrors the mesh. `spans` may omit rays beyond the lattice.
  SweptMesh(std::shared_ptr<const TriangleMesh> mesh, const Pose& start,
            const LatticeVector& motion, const Lattice& lattice);

  LatticeBox bounds() const override { return {bounds_}; }

 private:
  // For each tile of one field: the triangles that can reach its rays.
  struct Bins {
    int u = 0, v = 0, across = 0, down = 0;  // first tile (u, v); number of tiles along u and v
    // For each tile: the index in `triangles` where its triangles begin. The last entry is the end.
    std::vector<uint32_t> first;
    std::vector<uint32_t> triangles;
    std::vector<std::array<double, 4>> rects;  // swept_rect of each triangle
  };

  // Values of a triangle and of the prism that it sweeps. They do not depend on the field.
  struct Face {
    Vec3 normal;          // its length is twice the triangle's area
    double along_motion;  // minus the dot product of normal and motion
    // The prism is edge-on to a ray if |depth component of the normal| + |along_motion| is below
    // this.
    double edge_on;
    Vec3 edge_normal[3];  // in the triangle's plane, towards its inside
    double edge_along_motion[3];
    Vec3 side[3];  // outward normals of the prism's sides
  };

  void fill(const RayTile& rays, TileIntervals& all) const override;
  // Returns the corners of a triangle, counter-clockwise seen from outside.
  std::array<const Vec3*, 3> corners_of(uint32_t triangle) const;
  Face face_of(uint32_t triangle) const;
  void sort_into(Bins& bins, Axis axis, const Lattice& lattice) const;
  // Returns the rectangle in the (u, v) plane that a triangle sweeps: low and high u, low and high
  // v.
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
