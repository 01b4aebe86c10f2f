// SPDX-License-Identifier: MIT
// Indexed triangle meshes [mm]; counter-clockwise seen from outside.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <kibori/geometry/vec.h>

namespace kibori {

struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;

  Box bounds() const {
    Box box;
    for (const auto& triangle : triangles)
      for (uint32_t index : triangle) box.include(vertices[index]);
    return box;
  }
};

// A mesh to look at, print and send: what a model's surface becomes.
struct SurfaceVertex {
  std::array<float, 3> position;
  std::array<float, 3> normal;  // unit, out of the material
  uint8_t material;
  uint32_t paint;  // 0xAABBGGRR; 0: unpainted
};
using SurfaceTriangle = std::array<uint32_t, 3>;
struct Surface {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> triangles;
};

}  // namespace kibori
