// SPDX-License-Identifier: MIT
// Many cuts at once, on all cores. Each cut is a solid, for example one straight motion of a tool.
//
//   one by one:  for each cut: for each tile it touches       a tile is loaded for every cut
//   batch:       for each tile: for each cut that touches it  tiles share nothing: one thread each
//
// Within a tile the cuts keep their order, so the model is the same as one by one. Sums of a cut
// are made tile by tile and added in the order of fields and tiles. So they depend neither on the
// number of threads nor on how cuts are divided into batches.
//
// If an end is on a node, the sums of the x and y fields read the z field. One by one, that is the
// z field before their own cut. In a batch, it is the z field before the whole batch, so the
// earlier cuts are checked too (removed_earlier).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/edit.h>
#include <kibori/solid/solid.h>

namespace kibori {

struct BatchCut {
  const Solid* solid = nullptr;
  // Point about which moments are computed [lattice units].
  LatticePoint reference;
  // Direction of the motion, used only for the sums of chips. Zero: none.
  LatticeVector shift;
  bool writes = true;  // false: computes what a cut would remove at this place of the order
  bool chip = false;   // also computes second moments
};

// Result of one cut, over all materials, in lattice units (dexel/volume.h).
struct CutSums {
  int64_t points = 0;  // lattice nodes
  double volume = 0;
  Vec3 moment = Vec3::Zero();      // first moment about BatchCut::reference
  std::array<double, 6> second{};  // second moments: xx, yy, zz, xy, xz, yz

  void add(const CutSums& other);
};

// Fields that a batch edits. If only the z field is edited, the model has no surface, and sums
// count only the z field's share.
enum class BatchFields { all, z_only };

struct BatchOptions {
  int threads = 1;  // does not change the result
  BatchFields fields = BatchFields::all;
};

// Applies the cuts in order and returns their sums, in the same order. The solids must stay valid
// during the call. Needs a model that no other thread writes. Memory: the touched tiles twice, if
// threads > 1.
std::vector<CutSums> cut_batch(TriDexel& model, std::span<const BatchCut> cuts,
                               const BatchOptions& options);

}  // namespace kibori
