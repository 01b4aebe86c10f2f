// SPDX-License-Identifier: MIT
// Converts faces with any number of corners to triangles. Internal to `formats`.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <kibori/geometry/mesh.h>

namespace kibori {

// A convex face becomes a fan around its first corner. A concave one is cut into ears when all
// vertices are known, because a face may come before its vertices in the file.
class Polygons {
 public:
  // Appends a face. With fewer than three corners it has no triangles.
  void add(TriangleMesh& mesh, std::span<const uint32_t> corners);
  // Replaces the fans of concave faces; call it once, when every index has its vertex. Time is
  // bounded by a constant for each corner. A face that exceeds it keeps a part of its fan. Its
  // triangles overlap but have the same signed volume.
  void finish(TriangleMesh& mesh) const;

 private:
  struct Fan {
    size_t first;  // index of its first triangle
    size_t count;  // number of its triangles, at least two
  };
  std::vector<Fan> fans_;
};

}  // namespace kibori
