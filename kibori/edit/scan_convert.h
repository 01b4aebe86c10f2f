// SPDX-License-Identifier: MIT
// Scan conversion: converts a triangle mesh into the three dexel fields.
//
// crossings.h finds where each ray crosses the mesh, exactly. A ray is inside where its winding
// number is not zero. If the winding number is not zero at the end of the ray, the ray passed
// through a hole. Such a ray is called open. Then the three fields vote on every lattice node. If a
// node's closed rays agree, they decide; otherwise its open rays vote, too. So a hole closes where
// the other two directions agree, and the three fields agree at every node.
#pragma once

#include <cstdint>
#include <string>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

struct ScanReport {
  int64_t rays = 0;       // rays that meet the mesh
  int64_t open_rays = 0;  // rays whose crossings do not close
  // How often a field lost the vote on a node, except where only rounding was the reason.
  int64_t outvoted = 0;
  int64_t placed_ends = 0;  // ends without a crossing, placed midway between nodes
  bool repaired() const { return open_rays > 0 || outvoted > 0; }
  // One sentence for the user; empty if nothing was repaired.
  std::string warning() const;
};

struct ScanOptions {
  bool force = false;  // accept a mesh even if many of its rays are open
  int threads = 1;     // 1..3; the result does not depend on it
};

// Fills an empty model with the mesh. Errors: no triangles; a mesh outside the lattice; too many
// crossings; too many open rays without `force`.
Result<ScanReport> scan_convert(TriDexel& model, const TriangleMesh& mesh, uint8_t material,
                                const ScanOptions& options = {});

}  // namespace kibori
