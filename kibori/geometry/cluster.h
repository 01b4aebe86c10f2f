// SPDX-License-Identifier: MIT
// Reduces a mesh to fewer triangles, for display only.
#pragma once

#include <kibori/geometry/mesh.h>

namespace kibori {

// Returns a mesh with at most `max_triangles` triangles. If `mesh` has no more than that, the
// function only merges vertices with the same float32 position. Otherwise it divides space into
// cubic cells. All vertices in a cell become one vertex at their mean (Rossignac and Borrel,
// "Multi-resolution 3D approximations", 1993). The result may be open and may intersect itself. The
// function needs memory for the result and at most 2^21 cells, for a mesh of any size.
TriangleMesh cluster(const TriangleMesh& mesh, size_t max_triangles);

}  // namespace kibori
