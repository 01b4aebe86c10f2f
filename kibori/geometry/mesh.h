// SPDX-License-Identifier: MIT
// An indexed triangle mesh [mm]; counter-clockwise seen from outside.
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

}  // namespace kibori
