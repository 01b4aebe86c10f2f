// SPDX-License-Identifier: MIT
// Dabs (changes within a brush) of paint and of masks. They change the colour or the mask of the
// surface, but move nothing.
#pragma once

#include <cstdint>
#include <span>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/material.h>
#include <kibori/reshape/brush.h>

namespace kibori {

// Blends the brush's colour into every end of the surface within the brush. The share of the
// brush's colour is strength times falloff, minus what the mask protects. An unpainted end starts
// with the colour of its material. The falloffs of several places add up, to at most 1. Returns the
// number of ends whose colour changed. `materials` must not be empty. If it has no element for a
// material number, its last element is used. Errors: check_brush rejects the brush; a place is not
// finite.
Result<int64_t> paint_dab(TriDexel& model, const Brush& brush, std::span<const DabPlace> at,
                          std::span<const Material> materials);

// Changes the mask of every end within the brush by the rule brush.mask, with the share strength
// times falloff. Returns the number of ends whose mask changed. Errors: check_brush rejects the
// brush (a mask by height needs a plane); a place is not finite.
Result<int64_t> mask_dab(TriDexel& model, const Brush& brush, std::span<const DabPlace> at);

}  // namespace kibori
