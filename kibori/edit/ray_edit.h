// SPDX-License-Identifier: MIT
// Edits of a single ray: the cases that the vector code of tile_kernel.cpp cannot handle, such as a
// deposit that joins two spans. Internal to `edit`, `reshape` and `body`.
#pragma once

#include <vector>

#include <kibori/dexel/field.h>

namespace kibori {

// Removes [a, b) from the ray in `slot`. A new end keeps the normal of the old end until the caller
// sets it.
void cut_ray(Field& field, Tile& tile, int slot, float a, float b);

// Keeps the spans of the ray in `slot` whose flag in `keep` is set, and removes the others. `keep`:
// one flag per span, in order.
void keep_spans(Field& field, Tile& tile, int slot, const std::vector<bool>& keep);

// Fills the empty parts of [a, b) with `material`. Touching spans of the same material are joined.
void deposit_ray(Field& field, Tile& tile, int slot, float a, float b, uint8_t material);

}  // namespace kibori
