// SPDX-License-Identifier: MIT
// Reduces the number of triangles, for display and export.
#pragma once

#include <kibori/geometry/mesh.h>

namespace kibori {

// Returns a surface with fewer triangles, within about tolerance_mm of `surface` in both
// directions. The input must be a closed two-manifold; parts that are not stay unchanged. The
// result is a closed two-manifold without degenerate triangles. Every vertex is one of the old
// vertices, so no two have the same position. Sharp edges and colour borders are kept.
//
// The algorithm merges vertices into neighbours, lowest error first (quadrics: Garland and
// Heckbert, 1997). A merge is done only if the link condition holds (Dey et al., 1999) and no
// triangle turns over. The sum of all distances that the surface has moved there must stay below
// the tolerance.
Surface simplify(const Surface& surface, double tolerance_mm);

}  // namespace kibori
