// SPDX-License-Identifier: MIT
// The inner loop of every edit. It applies one layer of a solid's intervals to one tile. Internal
// to `edit`.
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

// The vectorised part of run_tile. tile_kernel() returns the version for this processor's best
// instruction set.
using TileKernel = void (*)(TileJob&);
TileKernel tile_kernel();

// The part of a job that is the same for all tiles of one field.
struct TileRequest {
  Operation operation;
  TileKernel kernel;
  Field* field;  // null for contact and deposit_contact
  const Solid* solid;
  const Motion* motion;
  // The z field of the model. It decides tied ends (dexel/volume.h) of the x and y fields. Null:
  // float32 rounding decides.
  const FieldSnapshot* z;
  std::array<int, 2> z_begin, z_end;  // nodes of `z` in the tiles that the solid's bounds touch
  float depth_begin, depth_end;       // range of the field's depths
  double depth_min, depth_max;        // range of the solid's depths, with kBoundsSlack
  float t_ref;                        // whole number near the middle of the tool's depths
  float u_ref, v_ref;                 // whole numbers near the middle of the tool's u and v
  bool deep;                          // true: the tool is too deep for exact node sums in float32
  uint8_t material = kMixedMaterial;  // of a deposit; otherwise each span's own material counts
  Color color = 0;                    // of paint
  // The earlier cuts of a batch, which are not in `z` yet; null: none. See batch.h.
  const EarlierCuts* earlier = nullptr;
};

// True if an earlier cut of the batch has removed the node, or made an end within kTie of it.
bool removed_earlier(const EarlierCuts& earlier, const Index3& node);

// Sums over the tiles of one field, for each of the 16 lanes, in lattice units. They are doubles,
// so that whole numbers stay exact. Each quantity has four sums: one without a weight, and three
// with the weights _u0, _v and _t2. _u0 is the u of the tile's first ray, _v the ray's v, and _t2
// is 2 (depth - t_ref).
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
    weighted,  // corrections and nodes, weighted by the resistance of the rings (edit/grain.h)
    weighted_u0,
    weighted_v,
    weighted_t2,
    kCount
  };
  alignas(64) double of[kCount][kTileSide];  // valid if `material` is not kMixedMaterial
  uint8_t material = kMixedMaterial;         // material of these sums; kMixedMaterial: no sums yet
};

// Sums for the shape of the chip (RemovedPart::ChipSums), for each of the 16 lanes. `uu` to `t2t2`
// are second moments of the volume. In them, u is relative to u_ref, v to v_ref, and t2 (twice the
// depth) to 2 t_ref. `front` to `front_t` are sums over the ends that the tool made.
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
  alignas(64) double of[kCount][kTileSide];  // valid if LaneSums::of is valid
};

// Rays that the vector code cannot handle: for each row, a mask of lanes. edit_scalar_rays edits
// these rays.
struct ScalarRays {
  uint16_t rows[kTileSide] = {};
  bool any = false;
};

struct TileJob {
  const TileRequest request;
  Removed* const removed;  // receives the sums

  // Leaves spans and sums uninitialised, because clearing them takes longer than a small edit.
  TileJob(const TileRequest& what, Removed& to) : request(what), removed(&to) {}

  // The indices of the tile, and of the layer of the solid that is applied to the tile.
  int tu = 0, tv = 0, layer = 0;
  RayTile rays = {};
  const Tile* tile = nullptr;  // current content
  Tile* writable = nullptr;    // the same tile once it may be written; otherwise null

  // Working memory. Between tiles, only the spans and the sums have content.
  SpanLayer spans;
  EndMasks ends = {};        // ends that the tool made and whose normals are not stored yet
  uint16_t adds[kTileSide];  // deposit: lanes that get material, for each row of `spans`
  ScalarRays scalar;
  LaneSums sums;
  ChipLanes chip;
  std::array<CellSet, 3> chip_cells = {};
  uint8_t sums_material = kMixedMaterial;  // material of this tile's sums; kMixedMaterial: several
  uint16_t gaps = 0;                       // rows in which spans vanished, one bit each

  // Layer `ties_layer` of the solid for a tile of the z field. It decides tied ends. Only the last
  // tile is kept.
  SpanLayer ties;
  RayTile ties_rays = {Axis::z, -1, -1};
  int ties_layer = 0;
  bool ties_any = false;

  // Results for the tile.
  bool met = false;     // true: the tool removes or adds material
  bool shrank = false;  // true: a plane may have become empty
};

// Applies `job.request` to the tile. If a snapshot shares the tile, the tile is copied before a
// write.
void run_tile(TileJob& job);

// Adds `job.sums` to `job.removed`. Call it after the last tile.
void flush_sums(TileJob& job);

// Flushes `job.sums`, and clears it for sums of `job.sums_material`. Call it only if the tool meets
// material. Then `job.removed` contains only materials that the tool has met.
void take_sums(TileJob& job);

}  // namespace kibori
