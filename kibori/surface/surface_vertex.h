// SPDX-License-Identifier: MIT
// Computes the position of one sheet's vertex. Internal to `surface`.
#pragma once

#include <kibori/surface/chunk_kernel.h>

namespace kibori {

// Maximum number of faces from other cells that affect the position of a vertex.
inline constexpr int kMaxAdjacentFaces = 3;

// The ends of material that belong to one sheet, on the edges of a cell, and sums over these ends.
// `points` and `normals` then continue with faces of other cells (add_adjacent). These faces affect
// the vertex's position, but not the sums.
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
  Vec4f point;   // relative to the cell's centre; each coordinate is within kVertexReach
  Vec4f normal;  // unit
  int rank;      // 1 on a smooth surface, 2 on a sharp edge, 3 in a corner
};

// Maximum coordinate of a vertex, relative to the cell's centre [lattice units]. A vertex on a
// sharp edge may be half a cell outside its cell. A tighter limit would blunt oblique edges.
inline constexpr float kVertexReach = 1.0f;
// Normals belong to one face if the cosine of the angle between each normal and their mean is at
// least this.
inline constexpr float kFlat = 0.98f;

// Returns the point that fits the planes of the ends best (least squares). In directions that the
// planes do not determine, it is as near as possible to the mean of the ends. Source: Ju et al.,
// Dual contouring of Hermite data, 2002.
SheetVertex place_vertex(const SheetEnds& ends);

// True if the vertex is so far from its ends that faces of other cells may be nearer.
bool is_far(const SheetEnds& ends, const SheetVertex& vertex);

// `vertex` is the result of place_vertex: the corner where the faces of `ends` meet. Another face,
// through `point` with `normal`, may cut off this corner. Returns how far the vertex is beyond that
// face [lattice units]. Returns 0 if the vertex is not beyond the face. Also returns 0 if the faces
// do not form one convex corner of material or of empty space.
float passes(const SheetEnds& ends, const SheetVertex& vertex, const Vec4f& point,
             const Vec4f& normal);

}  // namespace kibori
