// SPDX-License-Identifier: MIT
// Where one sheet's vertex goes. Internal to `surface`.
#pragma once

#include <kibori/geometry/vec.h>

namespace kibori {

// Ends of material on the edges of a cell that belong to one sheet.
struct SheetEnds {
  int count = 0;
  int with_normal = 0;
  Vec3 points[12];   // relative to the cell's centre [lattice units]
  Vec3 normals[12];  // unit; zero where none is known
};

struct SheetVertex {
  Vec3 point;   // relative to the cell's centre, within kVertexReach of it along each axis
  Vec3 normal;  // unit
  int rank;     // 1 on a smooth surface, 2 on a sharp edge, 3 in a corner
};

// A vertex may leave its cell by half a cell where sharpness needs it; clamping would blunt oblique edges.
inline constexpr double kVertexReach = 1.0;

// The point that fits the planes of the ends best (least squares), as near as may be to their mean where they
// leave it free. Ju et al., Dual contouring of Hermite data, 2002.
SheetVertex place_vertex(const SheetEnds& ends);

}  // namespace kibori
