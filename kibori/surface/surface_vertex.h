// SPDX-License-Identifier: MIT
// Computes the position of one sheet's vertex. Internal to `surface`.
#pragma once

#include <kibori/surface/chunk_kernel.h>

namespace kibori {

// Maximum number of faces of other cells that a vertex is kept from passing.
inline constexpr int kMaxAdjacentFaces = 3;

// Ends of material on the edges of a cell that belong to one sheet, and their sums. Faces that only
// limit the vertex follow them.
struct SheetEnds {
  int count = 0, adjacent_faces = 0;
  int with_normal = 0;
  Vec4f points[12 + kMaxAdjacentFaces];   // relative to the cell's centre [lattice units]
  Vec4f normals[12 + kMaxAdjacentFaces];  // unit; zero if unknown
  Vec4f point_sum = Vec4f::Zero(), normal_sum = Vec4f::Zero(), products = Vec4f::Zero();

  void add(const Vec4f& point, const Vec4f& normal) {
    points[count] = point;
    normals[count] = normal;
    count++;
    point_sum += point;
    normal_sum += normal;
    products += point.cwiseProduct(normal);
  }
  void add_adjacent(const Vec4f& point, const Vec4f& normal) {
    points[count + adjacent_faces] = point;
    normals[count + adjacent_faces] = normal;
    adjacent_faces++;
  }
  int planes() const { return count + adjacent_faces; }
  Vec4f mean() const { return point_sum * (1 / static_cast<float>(count)); }
  float distance_to(const Vec4f& place) const { return (place - mean()).norm(); }
};

// The vertex of one sheet.
struct SheetVertex {
  Vec4f point;   // relative to the cell's centre, within kVertexReach of it along each axis
  Vec4f normal;  // unit
  int rank;      // 1 on a smooth surface, 2 on a sharp edge, 3 in a corner
};

// A vertex may leave its cell by half a cell if a sharp edge needs it. A tighter limit would blunt
// oblique edges.
inline constexpr float kVertexReach = 1.0f;
// Normals within acos of this of their mean belong to one face.
inline constexpr float kFlat = 0.98f;

// The point that fits the planes of the ends best (least squares). In directions that they leave
// free, it is as near as possible to the mean of the ends. Ju et al., Dual contouring of Hermite
// data, 2002.
SheetVertex place_vertex(const SheetEnds& ends);

// True if a vertex is so far from its ends that faces of other cells may be nearer.
bool is_far(const SheetEnds& ends, const SheetVertex& vertex);

// The distance [lattice units] by which `vertex`, placed by `ends`, passes the face of another end.
// 0 if it does not pass. A sharp vertex is where its faces meet. If another face bounds the same
// convex corner of material or of empty space, it cuts them off earlier.
float passes(const SheetEnds& ends, const SheetVertex& vertex, const Vec4f& point,
             const Vec4f& normal);

}  // namespace kibori
