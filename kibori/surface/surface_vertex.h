// SPDX-License-Identifier: MIT
// Where one sheet's vertex goes. Internal to `surface`.
#pragma once

#include <kibori/surface/chunk_kernel.h>

namespace kibori {

// Ends of material on the edges of a cell that belong to one sheet, and their sums.
struct SheetEnds {
  int count = 0;
  int with_normal = 0;
  Vec4f points[12];   // relative to the cell's centre [lattice units]
  Vec4f normals[12];  // unit; zero where none is known
  Vec4f point_sum = Vec4f::Zero(), normal_sum = Vec4f::Zero(), products = Vec4f::Zero();

  void add(const Vec4f& point, const Vec4f& normal) {
    points[count] = point;
    normals[count] = normal;
    count++;
    point_sum += point;
    normal_sum += normal;
    products += point.cwiseProduct(normal);
  }
};

struct SheetVertex {
  Vec4f point;   // relative to the cell's centre, within kVertexReach of it along each axis
  Vec4f normal;  // unit
  int rank;      // 1 on a smooth surface, 2 on a sharp edge, 3 in a corner
};

// A vertex may leave its cell by half a cell where sharpness needs it; clamping would blunt oblique
// edges.
inline constexpr float kVertexReach = 1.0f;
// Normals within acos of this of their mean are of one face.
inline constexpr float kFlat = 0.98f;

// The point that fits the planes of the ends best (least squares), as near as may be to their mean
// where they leave it free. Ju et al., Dual contouring of Hermite data, 2002.
SheetVertex place_vertex(const SheetEnds& ends);

}  // namespace kibori
