// SPDX-License-Identifier: MIT
// Paint and masks: dabs that change the colour or the mask of the surface within a brush, and move
// nothing.
#pragma once

#include <cstdint>
#include <span>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/material.h>
#include <kibori/reshape/brush.h>

namespace kibori {

// Blends the brush's colour into every end of the surface within it, with strength times falloff.
// An unpainted end starts with its material's colour. Falloffs of several places add up, to at most
// 1. Returns the number of ends whose colour changed. `materials` must not be empty. A material
// number beyond it uses the last one. Errors: a brush that check_brush rejects, or a place that is
// not finite.
Result<int64_t> paint_dab(TriDexel& model, const Brush& brush, std::span<const DabPlace> at,
                          std::span<const Material> materials);

// Changes the mask of every end within the brush by the rule brush.mask, with strength times
// falloff. Returns the number of ends whose mask changed. Errors: as those of paint_dab; a mask by
// height without a plane.
Result<int64_t> mask_dab(TriDexel& model, const Brush& brush, std::span<const DabPlace> at);

}  // namespace kibori
