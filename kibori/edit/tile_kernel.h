// SPDX-License-Identifier: MIT
// The inner loop of every edit: applies one layer of a solid's intervals to one tile. Internal to
// `edit`.
#pragma once

#include <array>

#include <kibori/dexel/field.h>
#include <kibori/edit/edit.h>
#include <kibori/edit/removed.h>
#include <kibori/solid/solid.h>

namespace kibori {

struct TileJob;
class EarlierCuts;
enum class Operation { cut, deposit, paint, contact, deposit_contact };

// The vectorised part of run_tile, for the best instruction set of this machine.
using TileKernel = void (*)(TileJob&);
TileKernel tile_kernel();

// The part of a job that is the same for all tiles of one field.
struct TileRequest {
  Operation operation;
  TileKernel kernel;
  Field* field;  // null for contact and deposit_contact
  const Solid* solid;
  const Motion* motion;
  // The z field. It decides tied ends (dexel/volume.h) of x and y; null: float32 rounding decides.
  const FieldSnapshot* z;
  std::array<int, 2> z_begin, z_end;  // nodes of `z` in the tiles that the solid's bounds touch
  float depth_begin, depth_end;       // of the field
  double depth_min, depth_max;        // of the solid, with kBoundsSlack
  float t_ref;                        // whole number near the middle of the tool's depths
  float u_ref, v_ref;                 // the same for its u and its v
  bool deep;                          // the tool is too deep for exact node sums in float32
  uint8_t material = kMixedMaterial;  // of a deposit; otherwise each span's own material counts
  Color color = 0;                    // of paint
  // Earlier cuts of a batch, which `z` does not contain yet; null: none. See batch.h.
  const EarlierCuts* earlier = nullptr;
};

// True if an earlier cut of the batch has removed the node, or made an end within kTie of it.
bool removed_earlier(const EarlierCuts& earlier, const Index3& node);

// Sums over the tiles of one field, by lane, in lattice units. They are doubles, so that whole
// numbers stay exact. Each quantity has four sums: without a weight, and weighted by the tile's
// first u (_u0), by v (_v), and by twice (depth - t_ref) (_t2).
struct LaneSums {
  enum Of : uint8_t {
    correction,  // of the ends (dexel/volume.h)
    correction_u0,
    correction_v,
    correction_t2,
    nodes,  // of the z field
    nodes_u0,
    nodes_v,
    nodes_t2,
    weighted,  // both, weighted by the resistance of the wood's rings (edit/grain.h)
    weighted_u0,
    weighted_v,
    weighted_t2,
    kCount
  };
  alignas(64) double of[kCount][kTileSide];  // valid once `material` is set
  uint8_t material = kMixedMaterial;         // material of these sums; kMixedMaterial: no sums yet
};

// Sums by lane for the shape of the chip (RemovedPart::ChipSums). Second moments of the volume: u
// is relative to u_ref, v to v_ref, and t2 (twice the depth) to 2 t_ref. The sums `front`... are
// over the ends that the tool made.
struct ChipLanes {
  enum Of : uint8_t {
    uu,
    uv,
    vv,
    ut2,
    vt2,
    t2t2,
    length,
    front,
    front_u,
    front_v,
    front_t,
    kCount
  };
  alignas(64) double of[kCount][kTileSide];  // valid while LaneSums are
};

// Rays that the vector code cannot handle: the mask of their lanes, by row. edit_scalar_rays edits
// them.
struct ScalarRays {
  uint16_t rows[kTileSide] = {};
  bool any = false;
};

struct TileJob {
  const TileRequest request;
  Removed* const removed;  // receives the sums

  // Does not initialise spans and sums: clearing them takes longer than a small edit.
  TileJob(const TileRequest& what, Removed& to) : request(what), removed(&to) {}

  // The tile, and the layer of the solid that is applied to it.
  int tu = 0, tv = 0, layer = 0;
  RayTile rays = {};
  const Tile* tile = nullptr;  // current content
  Tile* writable = nullptr;    // the same tile once it may be written; else null

  // Working memory. Between tiles it is empty, except for the spans and the sums.
  SpanLayer spans;
  EndMasks ends = {};        // ends that the tool made, whose normals are not stored yet
  uint16_t adds[kTileSide];  // deposit: lanes in which it adds material, for the rows of `spans`
  ScalarRays scalar;
  LaneSums sums;
  ChipLanes chip;
  std::array<CellSet, 3> chip_cells = {};
  uint8_t sums_material = kMixedMaterial;  // of this tile's sums; kMixedMaterial: several
  uint16_t gaps = 0;                       // rows in which spans vanished

  // Layer `ties_layer` of the solid along z, for tied ends. Caches the tile of the last request.
  SpanLayer ties;
  RayTile ties_rays = {Axis::z, -1, -1};
  int ties_layer = 0;
  bool ties_any = false;

  // Results.
  bool met = false;     // the tool removes or adds material
  bool shrank = false;  // a plane may have become empty
};

// Executes `job.request` on the tile. A write first copies the tile if a snapshot shares it.
void run_tile(TileJob& job);

// Adds `job.sums` to `job.removed`. Call it after the last tile.
void flush_sums(TileJob& job);

// Flushes `job.sums`, and clears it for sums of `job.sums_material`. Called only if the tool meets
// material, so that `job.removed` contains only materials that the tool met.
void take_sums(TileJob& job);

}  // namespace kibori
