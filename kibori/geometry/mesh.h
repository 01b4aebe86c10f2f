// SPDX-License-Identifier: MIT
// Indexed triangle meshes [mm], counter-clockwise seen from outside.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <kibori/geometry/color.h>
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

// A mesh for display, printing and transfer. Surface extraction produces it.
struct SurfaceVertex {
  std::array<float, 3> position;
  std::array<float, 3> normal;  // unit, out of the material
  uint8_t material;
  Color paint;
};
using SurfaceTriangle = std::array<uint32_t, 3>;
struct Surface {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> triangles;
};

// A piece of a surface in a stream. Its first `own` vertices are new. Their numbers continue from
// the pieces before. The other vertices belong to other pieces, earlier or later. `number` is each
// vertex's number in the whole surface.
struct SurfacePart {
  std::span<const SurfaceVertex> vertices;
  std::span<const SurfaceTriangle> triangles;  // of `vertices`
  std::span<const uint32_t> number;
  size_t own;
};
using SurfaceSink = std::function<void(const SurfacePart&)>;

// Converts a mesh to a surface. Vertices with the same float32 position become one vertex.
// Triangles with two equal corners are dropped then. Normals are the mean of the adjacent faces,
// weighted by angle. The material is 0.
Surface surface_of_mesh(const TriangleMesh& mesh);

// Sends a surface in one piece.
void send_surface(const Surface& surface, const SurfaceSink& sink);

}  // namespace kibori
