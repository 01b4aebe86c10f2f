// SPDX-License-Identifier: MIT
// Converts faces with any number of corners to triangles. Internal to `formats`.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <kibori/geometry/mesh.h>

namespace kibori {

// Call add() for each face, and finish() when all vertices are known. (In a file, a face may come
// before its vertices.) A convex face becomes a fan of triangles around its first corner. A concave
// face is divided by ear clipping.
class Polygons {
 public:
  // Appends a face as a fan. Faces with fewer than three corners add no triangle.
  void add(TriangleMesh& mesh, std::span<const uint32_t> corners);
  // Replaces the fans of concave faces. Call it once, after all vertices were added. All large
  // faces share a time of some seconds. When this time is used up, the rest of a face becomes a
  // fan. The triangles of such a fan may overlap, but the signed volume is correct.
  void finish(TriangleMesh& mesh) const;

 private:
  struct Fan {
    size_t first;  // index of the fan's first triangle
    size_t count;  // number of triangles, at least two
  };
  std::vector<Fan> fans_;
};

}  // namespace kibori
