// SPDX-License-Identifier: MIT
// Reduces a mesh to fewer triangles, for display only.
#pragma once

#include <kibori/geometry/mesh.h>

namespace kibori {

// Returns a mesh with at most `max_triangles`. In a mesh that is small enough, only vertices with
// the same float32 position are merged. In a larger mesh, all vertices in a cell of a cubic grid
// become their mean (Rossignac and Borrel, "Multi-resolution 3D approximations", 1993). The result
// may be open and may intersect itself. It needs memory for the result and for a grid of at most
// 2^21 cells, however large the mesh is.
TriangleMesh cluster(const TriangleMesh& mesh, size_t max_triangles);

}  // namespace kibori
