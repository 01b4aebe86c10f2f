// SPDX-License-Identifier: MIT
// Fewer triangles for display and export.
#pragma once

#include <kibori/geometry/mesh.h>

namespace kibori {

// A closed two-manifold with fewer triangles, within about tolerance_mm of `surface` both ways;
// closed and two-manifold again, no degenerate triangle, every vertex one of the old (so no two in
// one place), sharp edges and borders of colours kept. Vertices are drawn into neighbours, least
// error first (quadrics: Garland and Heckbert, 1997), as long as the link condition holds (Dey et
// al., 1999), no triangle turns over, and the distances moved add up to less than the tolerance.
// The surface must be a closed two-manifold; what of it is not stays as it is.
Surface simplify(const Surface& surface, double tolerance_mm);

}  // namespace kibori
