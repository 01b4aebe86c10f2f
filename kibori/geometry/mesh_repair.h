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

// Returns null if there is nothing to repair. Vertices with the same position count as one.
// - Triangles that are there several times, facing one way or both ways: one of them stays if that
//   closes the mesh, or if they make up a closed surface of their own.
// - A closed body whose triangles face inwards, although the mesh as a whole faces outwards: it is
//   turned if it is not a hollow, that is if it reaches out of all other bodies' bounds.
// Time: n log n for n triangles. Memory: about 100 bytes per triangle.
std::optional<MeshRepair> repair_mesh(const TriangleMesh& mesh);

}  // namespace kibori
