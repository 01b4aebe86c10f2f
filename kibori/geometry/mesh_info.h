// SPDX-License-Identifier: MIT
// Measures of a triangle mesh: size, volume, topology.
#pragma once

#include <cstdint>

#include <kibori/geometry/mesh.h>

namespace kibori {

struct MeshInfo {
  Box bounds;             // [mm]
  double volume_mm3 = 0;  // enclosed volume, with a sign; meaningful only if `closed`
  double area_mm2 = 0;
  Vec3 centroid_mm = Vec3::Zero();  // of the volume if `closed`, otherwise of the area
  // Number of triangles with three different corners. Vertices with the same float32 position count
  // as one.
  size_t triangles = 0;
  size_t degenerate = 0;      // number of other triangles
  size_t components = 0;      // number of pieces; common edges connect the triangles of a piece
  size_t open_edges = 0;      // number of directed edges without a partner in reverse direction
  size_t overfull_edges = 0;  // number of edges with more than two triangles
  bool closed = false;        // true if no edge is open
  // True if the mesh is closed, no edge is overfull, no triangle is degenerate, and the triangles
  // around each vertex form one fan.
  bool manifold = false;
};

// Measures a surface without degenerate triangles. `degenerate` is the number of triangles that the
// caller has already dropped.
MeshInfo mesh_info(const Surface& surface, size_t degenerate = 0);

}  // namespace kibori
