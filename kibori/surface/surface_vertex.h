// SPDX-License-Identifier: MIT
// Where one sheet's vertex goes. Internal to `surface`.
#pragma once

#include <kibori/surface/chunk_kernel.h>

namespace kibori {

// Faces of other cells that a vertex is kept from passing, at most.
inline constexpr int kMaxFacesBeside = 3;

// Ends of material on the edges of a cell that belong to one sheet, and their sums; after them,
// faces that only bound where the vertex goes.
struct SheetEnds {
  int count = 0, faces_beside = 0;
  int with_normal = 0;
  Vec4f points[12 + kMaxFacesBeside];   // relative to the cell's centre [lattice units]
  Vec4f normals[12 + kMaxFacesBeside];  // unit; zero where none is known
  Vec4f point_sum = Vec4f::Zero(), normal_sum = Vec4f::Zero(), products = Vec4f::Zero();

  void add(const Vec4f& point, const Vec4f& normal) {
    points[count] = point;
    normals[count] = normal;
    count++;
    point_sum += point;
    normal_sum += normal;
    products += point.cwiseProduct(normal);
  }
  void add_beside(const Vec4f& point, const Vec4f& normal) {
    points[count + faces_beside] = point;
    normals[count + faces_beside] = normal;
    faces_beside++;
  }
  int planes() const { return count + faces_beside; }
  Vec4f mean() const { return point_sum * (1 / static_cast<float>(count)); }
  float way_to(const Vec4f& place) const { return (place - mean()).norm(); }
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

// Whether a vertex is so far from its ends that faces beside it may be nearer.
bool goes_far(const SheetEnds& ends, const SheetVertex& vertex);

// Whether `vertex`, placed by `ends`, passes the face of an end beside it: so much [lattice units],
// or 0. A sharp vertex is where its faces meet; a further face cuts them off before that where it
// and they bound one convex corner of the material, or of what is without.
float passes(const SheetEnds& ends, const SheetVertex& vertex, const Vec4f& point,
             const Vec4f& normal);

}  // namespace kibori
