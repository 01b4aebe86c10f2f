// SPDX-License-Identifier: MIT
// A mesh with fewer triangles, to look at only.
#pragma once

#include <kibori/geometry/mesh.h>

namespace kibori {

// At most `max_triangles`: a mesh that has no more stays as it is, but for corners in one float32
// place, which become one. Of a larger mesh all vertices in a cell of a cubic grid become their
// mean (Rossignac and Borrel, "Multi-resolution 3D approximations", 1993). The result may be open
// and meet itself. Takes memory for the result and a grid of 2 million cells at most, whatever the
// mesh.
TriangleMesh cluster(const TriangleMesh& mesh, size_t max_triangles);

}  // namespace kibori
