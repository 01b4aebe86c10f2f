// SPDX-License-Identifier: MIT
// Converts faces with any number of corners to triangles. Internal to `formats`.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <kibori/geometry/mesh.h>

namespace kibori {

// Call add for each face, and finish when all vertices are known: a face may come before its
// vertices in the file. A convex face becomes a fan around its first corner. A concave face is
// triangulated by ear clipping.
class Polygons {
 public:
  // Appends a face as a fan. A face with fewer than three corners adds no triangle.
  void add(TriangleMesh& mesh, std::span<const uint32_t> corners);
  // Replaces the fans of concave faces. Call it once, when every index has its vertex. The time is
  // limited to some seconds. If a face needs more, the rest of it becomes a fan. Triangles
  // of that fan may overlap, but the signed volume is correct.
  void finish(TriangleMesh& mesh) const;

 private:
  struct Fan {
    size_t first;  // index of its first triangle
    size_t count;  // number of its triangles, at least two
  };
  std::vector<Fan> fans_;
};

}  // namespace kibori
