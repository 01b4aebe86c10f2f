// SPDX-License-Identifier: MIT
// Stock to carve, with memory looked at first.
#pragma once

#include <memory>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/scan_convert.h>

namespace kibori {

// Ok, or one sentence saying how much memory a model of this lattice can take and which pitch would
// fit. mesh: scan conversion takes its share.
Status check_memory(const Lattice& lattice, bool mesh);

struct MeshStock {
  std::unique_ptr<TriDexel> model;
  ScanReport report;
};

// The mesh as a model, in its own coordinates, with room_mm of space around it. Errors: those of
// make_lattice, check_memory and scan_convert.
Result<MeshStock> stock_of_mesh(const TriangleMesh& mesh, double pitch_mm, double room_mm,
                                uint8_t material, int threads, bool force);

}  // namespace kibori
