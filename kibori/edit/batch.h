// SPDX-License-Identifier: MIT
// Applies many cuts to a model at once, on several threads. Each cut is a solid, for example one
// straight motion of a tool.
//
//   one by one:  for each cut: for each tile it touches       a tile is loaded for every cut
//   batch:       for each tile: for each cut that touches it  tiles share no data: run in parallel
//
// Within a tile, the cuts keep their order. Therefore, the model becomes the same as with the cuts
// one by one. The sums of a cut are computed for each tile, and added in the order of fields and
// tiles. Therefore, the sums depend neither on the number of threads, nor on how cuts are divided
// into batches.
//
// If an end of the x or y field is tied to a node (dexel/volume.h), the z field decides whether the
// cut removes the node. The state of the z field just before the cut must decide. But the threads
// read its state before the whole batch. Therefore, removed_earlier also checks whether an earlier
// cut of the batch has removed the node.
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
  // The point about which moments are computed.
  LatticePoint reference;
  // Displacement of the tool. Only ChipSums::front uses it. Zero: no displacement.
  LatticeVector shift;
  bool writes = true;  // false: only computes what the cut would remove after the earlier cuts
  bool chip = false;   // true: also computes second moments
};

// Sums over what one cut removes, over all materials, in lattice units (dexel/volume.h).
struct CutSums {
  int64_t points = 0;  // removed lattice nodes
  double volume = 0;
  Vec3 moment = Vec3::Zero();      // first moment about BatchCut::reference
  std::array<double, 6> second{};  // second moments: xx, yy, zz, xy, xz, yz

  void add(const CutSums& other);
};

// Fields that a batch edits. With z_only, the x and y fields stay unchanged. No surface can be
// computed from the model afterwards, and the sums have only the z field's share.
enum class BatchFields { all, z_only };

struct BatchOptions {
  int threads = 1;  // does not change the result
  BatchFields fields = BatchFields::all;
};

// Applies the cuts in order. Returns the sums of each cut, in the same order. The solids must stay
// valid during the call. No other thread may write the model meanwhile. With threads > 1, the call
// needs memory for a second copy of the touched tiles.
std::vector<CutSums> cut_batch(TriDexel& model, std::span<const BatchCut> cuts,
                               const BatchOptions& options);

}  // namespace kibori
