// SPDX-License-Identifier: MIT
// Applies a solid to one tile of one field. `edit.cpp` edits all tiles that a solid touches.
// `batch.cpp` applies to a tile all solids that touch it. Internal to `edit`.
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

// Tiles of the field with rays within the bounds, along its u and its v. Ray i is at i + 1/2.
TileRange tiles_along_u(const Box& bounds, const FieldSnapshot& field);
TileRange tiles_along_v(const Box& bounds, const FieldSnapshot& field);

// An edit of one field.
struct FieldEdit {
  Operation operation;
  const FieldSnapshot& view;
  Field* field;  // null for contact and deposit_contact
  const Solid& solid;
  const Motion& motion;
  const FieldSnapshot* z = nullptr;  // the model's z field before the edit; may be null
  uint8_t material = 0;
  Color color = 0;
};

// The request for all tiles of an edit. `bounds`: of the edit's solid.
TileRequest tile_request(const FieldEdit& edit, const Box& bounds);

// Edits one tile. Precondition: `job.spans.flip` is false if the edit adds material, otherwise
// true. The sums are complete in `job.removed` only after flush_sums.
void edit_tile(TileJob& job, const FieldSnapshot& view, int tu, int tv);

}  // namespace kibori
