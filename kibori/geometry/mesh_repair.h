// SPDX-License-Identifier: MIT
// Repairs typical faults of exported meshes: faces that exist twice, surfaces that face both ways,
// and bodies whose faces point inwards.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <kibori/geometry/mesh.h>

namespace kibori {

struct MeshRepair {
  std::vector<std::array<uint32_t, 3>> triangles;  // indices into the mesh's vertices
  size_t copies = 0;    // number of triangles left out, because others are in the same place
  size_t inverted = 0;  // number of inverted bodies whose triangles were reversed
  // Returns one sentence for the user, without the file's name.
  std::string warning() const;
};

// Repairs two faults. Returns nullopt if it finds neither. Vertices with the same position count as
// one.
// - Triangles exist several times, facing one way or both ways. The function keeps at most one copy
//   of each, in three cases only: this reduces the number of open edges; the whole mesh is
//   repeated; or such triangles form a closed surface of their own.
// - The triangles of a closed body face the opposite way to the mesh as a whole. The function
//   reverses them, unless the bounds of another body enclose the body: then it is a hollow.
//
// Time: n log n for n triangles, plus at most b^2 for b bodies. Memory: about 100 bytes per
// triangle.
std::optional<MeshRepair> repair_mesh(const TriangleMesh& mesh);

}  // namespace kibori
