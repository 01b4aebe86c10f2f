// SPDX-License-Identifier: MIT
// The inner loop of every edit: one layer of a solid's intervals against one tile. Internal to
// `edit`.
#pragma once

#include <kibori/dexel/field.h>
#include <kibori/edit/edit.h>
#include <kibori/edit/removed.h>
#include <kibori/solid/solid.h>

namespace kibori {

struct TileJob;
enum class Operation { cut, deposit, paint, contact, deposit_contact };

// The vector part of run_tile, for this machine's best instructions.
using TileKernel = void (*)(TileJob&);
TileKernel tile_kernel();

// What is asked of every tile that an edit of a field goes over.
struct TileRequest {
  Operation operation;
  TileKernel kernel;
  Field* field;  // null for contact: nothing is written
  const Solid* solid;
  const Motion* motion;
  double depth_min, depth_max;        // of the solid, with kBoundsSlack
  float t_ref;                        // whole number near the tool's depth
  bool deep;                          // the tool is too deep for node sums in float32
  uint8_t material = kMixedMaterial;  // of a deposit; else each span is asked for its own
  Color color = 0;                    // of paint
};

// Sums over the tiles of one field, by lane; lattice units. Doubles, so that whole numbers stay
// exact.
struct LaneSums {
  // Of each kind four: itself, _u0, _v and _t2, in this order.
  // clang-format off
  enum Of { length, length_u0, length_v, length_t2,
            nodes, nodes_u0, nodes_v, nodes_t2,
            felt, felt_u0, felt_v, felt_t2, kCount };
  // clang-format on
  // length: of what was removed; _u0: weighted by the tile's first u; _v: by v; _t2: by twice
  // (depth - t_ref); nodes: the same of lattice nodes, for the z field; felt: of lengths, each as
  // much as the rings in it resist (edit/grain.h). Meaningful once `material` is set.
  alignas(64) double of[kCount][kTileSide];
  uint8_t material = kMixedMaterial;  // whose sums these are; kMixedMaterial: nothing summed yet
};

// Lanes whose ray needs the scalar path, by row.
struct ScalarRays {
  uint16_t rows[kTileSide] = {};
  bool any = false;
};

struct TileJob {
  const TileRequest request;
  Removed* const removed;  // the sums go here

  // Spans and sums stay as memory was: clearing them would cost more than small edits do.
  TileJob(const TileRequest& what, Removed& to) : request(what), removed(&to) {}

  // The tile, and which layer of the solid meets it.
  int tu = 0, tv = 0, layer = 0;
  RayTile rays = {};
  const Tile* tile = nullptr;  // current content
  Tile* writable = nullptr;    // the same, once it may be written: the model's own

  // Scratch, empty between tiles but for the spans and the sums.
  SpanLayer spans;
  EndMasks ends = {};  // ends the tool made, whose normals are still to be asked for
  ScalarRays scalar;
  LaneSums sums;
  uint8_t sums_material = kMixedMaterial;  // of what this tile adds to `sums`
  uint16_t gaps = 0;                       // rows in which spans vanished

  // What came of it.
  bool met = false;     // the tool met something
  bool shrank = false;  // a plane may have become empty
};

// Does what `job.request` asks, on the tile. Writes copy the tile first if it is shared.
void run_tile(TileJob& job);

// Adds what `job.sums` holds to `job.removed`; to be called after the last tile.
void flush_sums(TileJob& job);

// Readies `job.sums` for sums of `job.sums_material`. Only called where the tool met something, so
// that nothing else shows in `job.removed`.
void take_sums(TileJob& job);

}  // namespace kibori
