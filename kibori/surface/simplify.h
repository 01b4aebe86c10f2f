// SPDX-License-Identifier: MIT
// Reduces the number of triangles, for display and export.
#pragma once

#include <kibori/geometry/mesh.h>

namespace kibori {

// Returns a surface with fewer triangles. Each of the two surfaces is within about tolerance_mm of
// the other. Parts of the input that are not a closed two-manifold stay unchanged. If the whole
// input is one, the result is one, too, and has no degenerate triangles. Each vertex of the result
// is a vertex of the input, so no two have the same position. Sharp edges and colour borders are
// kept.
//
// The algorithm merges vertices into their neighbours, the merge with the lowest error first
// (quadrics: Garland and Heckbert, 1997). It merges only if the link condition holds (Dey et al.,
// 1999) and no triangle turns over. It adds up the distances that the surface has moved at a place.
// The sum must stay below the tolerance.
Surface simplify(const Surface& surface, double tolerance_mm);

}  // namespace kibori
