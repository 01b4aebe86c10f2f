// SPDX-License-Identifier: MIT
// Measures of a triangle mesh: size, volume, topology.
#pragma once

#include <cstdint>

#include <kibori/geometry/mesh.h>

namespace kibori {

struct MeshInfo {
  Box bounds;             // [mm]
  double volume_mm3 = 0;  // enclosed, signed; meaningful only if closed
  double area_mm2 = 0;
  Vec3 centroid_mm = Vec3::Zero();  // of the volume if closed, otherwise of the area
  // Triangles with three different corners. Vertices with the same float32 position count as one.
  size_t triangles = 0;
  size_t degenerate = 0;      // all other triangles
  size_t components = 0;      // pieces that are connected by edges
  size_t open_edges = 0;      // directed edges without their reverse
  size_t overfull_edges = 0;  // edges of more than two triangles
  bool closed = false;        // every directed edge has its reverse
  // Closed, no overfull edge, no degenerate triangle, and one fan of triangles around each vertex.
  bool manifold = false;
};

// Measures a surface. `degenerate` is the number of triangles that were already dropped.
MeshInfo mesh_info(const Surface& surface, size_t degenerate = 0);

}  // namespace kibori
