// SPDX-License-Identifier: MIT
// Repairs typical faults of exported meshes: duplicate faces, surfaces that face both ways, and
// bodies that are inside out.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <kibori/geometry/mesh.h>

namespace kibori {

struct MeshRepair {
  std::vector<std::array<uint32_t, 3>> triangles;  // of the same vertices
  size_t copies = 0;    // triangles left out because another one is in the same place
  size_t inverted = 0;  // inverted bodies that were turned
  // One sentence for the user, without the file's name.
  std::string warning() const;
};

// Repairs two faults. Returns nullopt if it finds none. Vertices with the same position count as
// one.
// - A triangle exists several times, facing one way or both ways. One copy stays if that reduces
//   the number of open edges, or if such triangles form a closed surface of their own.
// - The triangles of a closed body face the opposite way to the mesh as a whole. The body is
//   turned, unless its bounds are within those of another body: then it is a hollow.
// Time: n log n for n triangles, plus at most b^2 for b bodies. Memory: about 100 bytes per
// triangle.
std::optional<MeshRepair> repair_mesh(const TriangleMesh& mesh);

}  // namespace kibori
