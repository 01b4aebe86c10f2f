// SPDX-License-Identifier: MIT
// Scan conversion: converts a triangle mesh into the three dexel fields.
//
// crossings.h finds exactly where each ray crosses the mesh. The winding number at a point of a ray
// is the number of entries into the mesh before it, minus the number of exits. The point is inside
// if its winding number is not zero. A ray is open if the number is not zero at the ray's end: the
// ray passed through a hole.
//
// Then the three fields vote on every lattice node, by the three rays through the node. If the rays
// that are not open agree, they decide. Otherwise, the open rays vote, too. Therefore, a hole is
// closed where the other two directions agree, and the three fields agree at every node.
#pragma once

#include <cstdint>
#include <string>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

struct ScanReport {
  int64_t rays = 0;       // rays that meet the mesh
  int64_t open_rays = 0;  // rays among them that are open
  // Number of lost votes: for each node, the fields that had to change. A vote that was lost only
  // because of rounding does not count.
  int64_t outvoted = 0;
  int64_t placed_ends = 0;  // ends without a crossing, which are placed midway between two nodes
  bool repaired() const { return open_rays > 0 || outvoted > 0; }
  // Returns one sentence for the user; empty if nothing was repaired.
  std::string warning() const;
};

struct ScanOptions {
  bool force = false;  // true: accept a mesh even if many of its rays are open
  int threads = 1;     // 1..3; the result does not depend on it
};

// Fills an empty model with the inside of the mesh. Errors: no triangles; a mesh outside the
// lattice; too many crossings; too many open rays, if `force` is false.
Result<ScanReport> scan_convert(TriDexel& model, const TriangleMesh& mesh, uint8_t material,
                                const ScanOptions& options = {});

}  // namespace kibori
