// SPDX-License-Identifier: MIT
// A triangle mesh as stock: scan conversion into the three dexel fields.
//
// Each ray is cut at its crossings (exact: crossings.h) and filled where the winding number is not
// zero. Rays that don't close (holes) are known by a winding number that does not come back to
// zero; then every lattice node is put to the vote of the three fields, closed rays before open
// ones, so holes close where the other two directions agree, and the three fields agree at every
// node.
#pragma once

#include <cstdint>
#include <string>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

struct ScanReport {
  int64_t rays = 0;       // that meet the mesh
  int64_t open_rays = 0;  // whose crossings don't close
  // (node, field) pairs where the field lost the vote by more than rounding.
  int64_t outvoted = 0;
  int64_t placed_ends = 0;  // ends put midway between nodes for want of a crossing
  bool repaired() const { return open_rays > 0 || outvoted > 0; }
  // One sentence for the user, empty when nothing was done.
  std::string warning() const;
};

struct ScanOptions {
  bool force = false;  // take a mesh whose rays mostly disagree
  int threads = 1;     // 1..3; the result does not depend on it
};

// Fills an empty model with the mesh. Errors: no triangle, a mesh that leaves the lattice, most
// rays open.
Result<ScanReport> scan_convert(TriDexel& model, const TriangleMesh& mesh, uint8_t material,
                                const ScanOptions& options = {});

}  // namespace kibori
