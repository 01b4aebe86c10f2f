// SPDX-License-Identifier: MIT
// Edits of a single ray: what the vectors of tile_kernel.cpp leave over, such as a deposit that
// joins two spans. Internal to `edit`, `reshape` and `body`.
#pragma once

#include <vector>

#include <kibori/dexel/field.h>

namespace kibori {

// Takes [a, b) away from the ray in `slot`. New ends keep the normals that were there; the caller
// sets them.
void cut_ray(Field& field, Tile& tile, int slot, float a, float b);

// Takes from the ray in `slot` all spans but those of `keep`: one for each that it has, in order.
void keep_spans(Field& field, Tile& tile, int slot, const std::vector<bool>& keep);

// Fills what is empty of [a, b) with `material`; spans of the same material that touch become one.
void deposit_ray(Field& field, Tile& tile, int slot, float a, float b, uint8_t material);

}  // namespace kibori
