// SPDX-License-Identifier: MIT
// Indexed triangle meshes [mm]; counter-clockwise seen from outside.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
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

// A piece of a surface on its way to somewhere. Its first `own` vertices are new and numbered on
// from those of the pieces before; the others belong to other pieces, earlier or later. `number`
// has each vertex's number in the whole surface.
struct SurfacePart {
  std::span<const SurfaceVertex> vertices;
  std::span<const SurfaceTriangle> triangles;  // of `vertices`
  std::span<const uint32_t> number;
  size_t own;
};
using SurfaceSink = std::function<void(const SurfacePart&)>;

// A mesh as a surface: corners in one float32 place become one vertex, normals are the mean of the
// faces around, by angle; material 0. Triangles that so lose a corner are left out.
Surface surface_of_mesh(const TriangleMesh& mesh);

// Sends a surface in one piece.
void send_surface(const Surface& surface, const SurfaceSink& sink);

}  // namespace kibori
