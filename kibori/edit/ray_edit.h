// SPDX-License-Identifier: MIT
// Edits a single ray. The vector code of tile_kernel.cpp cannot handle some cases, such as a
// deposit that joins two spans. These functions handle them. Internal to `edit`, `reshape` and
// `body`.
#pragma once

#include <vector>

#include <kibori/dexel/field.h>

namespace kibori {

// Removes [a, b) from the ray in `slot`. A new end keeps the normal of the span's old end until the
// caller sets the new normal.
void cut_ray(Field& field, Tile& tile, int slot, float a, float b);

// Removes those spans of the ray in `slot` whose flag in `keep` is false. `keep` has one flag for
// each span, in order.
void keep_spans(Field& field, Tile& tile, int slot, const std::vector<bool>& keep);

// Fills the empty parts of [a, b) with `material`. Joins touching spans that have the same
// material.
void deposit_ray(Field& field, Tile& tile, int slot, float a, float b, uint8_t material);

}  // namespace kibori
