// SPDX-License-Identifier: MIT
// Faces of any number of corners as triangles. Internal to `formats`.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <kibori/geometry/mesh.h>

namespace kibori {

// A convex face becomes a fan around its first corner. A concave one is cut into ears when all
// vertices are known: formats may name vertices that come later in the file.
class Polygons {
 public:
  // Appends a face. One of fewer than three corners has no triangles.
  void add(TriangleMesh& mesh, std::span<const uint32_t> corners);
  // Replaces the fans of concave faces; call it once, when every index has its vertex. Time is
  // bounded by a constant for each corner. A face that takes more keeps a part of its fan, whose
  // triangles overlap but have the same signed volume.
  void finish(TriangleMesh& mesh) const;

 private:
  struct Fan {
    size_t first;  // triangle
    size_t count;  // of triangles, at least two
  };
  std::vector<Fan> fans_;
};

}  // namespace kibori
