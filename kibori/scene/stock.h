// SPDX-License-Identifier: MIT
// Stock to carve, with memory looked at first.
#pragma once

#include <map>
#include <memory>
#include <optional>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/edit.h>
#include <kibori/edit/scan_convert.h>
#include <kibori/geometry/label_volume.h>
#include <kibori/solid/solid.h>

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

// A labelled volume, its lower corner at the origin: the voxels of each label are of the material
// that `materials` says, which must name all that the volume has; there must be some. Errors: those
// of make_lattice and check_memory; nothing is there at this pitch.
Result<std::unique_ptr<TriDexel>> stock_of_labels(const LabelVolume& volume,
                                                  const std::map<uint16_t, uint8_t>& materials,
                                                  double pitch_mm, std::optional<double> room_mm,
                                                  int threads);

// What the model has within a solid becomes of another material, its faces bit for bit as they
// were. False: it has nothing there.
bool change_material(TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& edit);

}  // namespace kibori
