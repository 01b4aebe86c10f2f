// SPDX-License-Identifier: MIT
// Computes the position of one sheet's vertex. Internal to `surface`.
#pragma once

#include <kibori/surface/chunk_kernel.h>

namespace kibori {

// Maximum number of faces of other cells that affect the position of a vertex.
inline constexpr int kMaxAdjacentFaces = 3;

// Ends of material on the edges of a cell that belong to one sheet, and their sums. After them come
// faces of other cells (add_adjacent). These affect the vertex's position, but not the sums.
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

// A vertex on a sharp edge may be outside its cell, by up to half a cell. A tighter limit would
// blunt oblique edges.
inline constexpr float kVertexReach = 1.0f;
// Normals belong to one face if the cosine of their angle to the mean is at least this.
inline constexpr float kFlat = 0.98f;

// The point that fits the planes of the ends best (least squares). Where the planes do not
// determine it, the point is as near as possible to the mean of the ends. Ju et al., Dual
// contouring of Hermite data, 2002.
SheetVertex place_vertex(const SheetEnds& ends);

// True if a vertex is so far from its ends that faces of other cells may be nearer.
bool is_far(const SheetEnds& ends, const SheetVertex& vertex);

// place_vertex placed `vertex` where the faces of `ends` meet. Another face, at `point` with
// `normal`, may cut off this corner. Returns the distance [lattice units] of the vertex beyond that
// face. Returns 0 if it is not beyond, or if the faces do not form one convex corner of material or
// of empty space.
float passes(const SheetEnds& ends, const SheetVertex& vertex, const Vec4f& point,
             const Vec4f& normal);

}  // namespace kibori
