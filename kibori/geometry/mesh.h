// SPDX-License-Identifier: MIT
// Triangle meshes with indexed vertices [mm]. Seen from outside, the corners of each triangle are
// in counter-clockwise order.
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

// A mesh with normals, materials and paint, for display, printing and transfer. extract_surface
// (surface/surface.h) makes it from a model.
struct SurfaceVertex {
  std::array<float, 3> position;
  std::array<float, 3> normal;  // unit; points out of the material
  uint8_t material;
  Color paint;
};
using SurfaceTriangle = std::array<uint32_t, 3>;
struct Surface {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> triangles;
};

// One part of a surface that is sent in several parts. The first `own` vertices are new. Their
// numbers in the whole surface continue those of the previous parts. All other vertices belong to
// earlier or later parts. `number` has the number of each vertex in the whole surface.
struct SurfacePart {
  std::span<const SurfaceVertex> vertices;
  std::span<const SurfaceTriangle> triangles;  // indices into `vertices`
  std::span<const uint32_t> number;
  size_t own;
};
using SurfaceSink = std::function<void(const SurfacePart&)>;

// Converts a mesh to a surface. Vertices with the same float32 position become one vertex. If two
// corners of a triangle are then equal, the triangle is dropped. A vertex's normal is the mean of
// its triangles' normals, weighted by their angles at the vertex. The material is 0.
Surface surface_of_mesh(const TriangleMesh& mesh);

// Sends a surface as one part.
void send_surface(const Surface& surface, const SurfaceSink& sink);

}  // namespace kibori
