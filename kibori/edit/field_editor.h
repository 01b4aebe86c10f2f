// SPDX-License-Identifier: MIT
// Applies a solid to one tile of one field. `edit.cpp` edits all tiles of a solid, `batch.cpp` all
// solids of a tile. Internal to `edit`.
#pragma once

#include <kibori/dexel/field.h>
#include <kibori/edit/edit.h>
#include <kibori/edit/removed.h>
#include <kibori/edit/tile_kernel.h>
#include <kibori/solid/solid.h>

namespace kibori {

// Tiles begin <= t < end along one direction of a field.
struct TileRange {
  int begin = 0, end = 0;

  bool holds(int tile) const { return begin <= tile && tile < end; }
};

// Tiles with rays within the bounds along a direction of the world (0: x, 1: y, 2: z) with `nodes`
// rays. Ray i is at i + 1/2.
TileRange tiles_along(const Box& bounds, int world, int nodes);

// An edit of one field.
struct FieldEdit {
  Operation operation;
  const FieldSnapshot& view;
  Field* field;  // null for contact
  const Solid& solid;
  const Motion& motion;
  const FieldSnapshot* z = nullptr;  // the model's, before the edit; may be null
  uint8_t material = 0;
  Color color = 0;
};

// The request for all tiles of an edit. `bounds`: those of its solid.
TileRequest tile_request(const FieldEdit& edit, const Box& bounds);

// Edits one tile. `job.spans.flip` must be set: true unless the edit adds material. Sums go to
// `job.removed` at the latest in flush_sums.
void edit_tile(TileJob& job, const FieldSnapshot& view, int tu, int tv);

}  // namespace kibori
