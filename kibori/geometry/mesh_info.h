// SPDX-License-Identifier: MIT
// What can be said of a triangle mesh by itself.
#pragma once

#include <cstdint>

#include <kibori/geometry/mesh.h>

namespace kibori {

struct MeshInfo {
  Box bounds;             // [mm]
  double volume_mm3 = 0;  // enclosed, signed; means little unless closed
  double area_mm2 = 0;
  Vec3 centroid_mm = Vec3::Zero();  // of the volume if closed, else of the area
  // Proper ones, after vertices in one float32 place have become one.
  size_t triangles = 0;
  size_t degenerate = 0;      // the others
  size_t components = 0;      // pieces that hang together by edges
  size_t open_edges = 0;      // directed edges without their reverse
  size_t overfull_edges = 0;  // edges of more than two triangles
  bool closed = false;        // every directed edge has its reverse
  // Closed, no edge overfull, and one fan of triangles around each vertex.
  bool manifold = false;
};

MeshInfo mesh_info(const Surface& surface, size_t degenerate = 0);

}  // namespace kibori
