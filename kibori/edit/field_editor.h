// SPDX-License-Identifier: MIT
// Applies a solid to one tile of one field. `edit.cpp` uses it for all tiles that one solid
// touches. `batch.cpp` uses it for all solids that touch one tile. Internal to `edit`.
#pragma once

#include <kibori/dexel/field.h>
#include <kibori/edit/edit.h>
#include <kibori/edit/removed.h>
#include <kibori/edit/tile_kernel.h>
#include <kibori/solid/solid.h>

namespace kibori {

// The tiles with begin <= index < end along one direction of a field.
struct TileRange {
  int begin = 0, end = 0;

  bool holds(int tile) const { return begin <= tile && tile < end; }
};

// Return the tiles of a field that have rays within the bounds, along u or along v. Ray i is at
// i + 1/2.
TileRange tiles_along_u(const Box& bounds, const FieldSnapshot& field);
TileRange tiles_along_v(const Box& bounds, const FieldSnapshot& field);

// An edit of one field.
struct FieldEdit {
  Operation operation;
  const FieldSnapshot& view;
  Field* field;  // null for contact and deposit_contact
  const Solid& solid;
  const Motion& motion;
  const FieldSnapshot* z = nullptr;  // the model's z field before the edit: see TileRequest::z
  uint8_t material = 0;
  Color color = 0;
};

// Returns the request for all tiles of an edit. `bounds` are the bounds of the edit's solid.
TileRequest tile_request(const FieldEdit& edit, const Box& bounds);

// Edits one tile. Precondition: `job.spans.flip` is false if the edit adds material, and true
// otherwise. `job.removed` has the complete sums only after flush_sums.
void edit_tile(TileJob& job, const FieldSnapshot& view, int tu, int tv);

}  // namespace kibori
