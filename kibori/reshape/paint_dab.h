// SPDX-License-Identifier: MIT
// Paint: a dab that colours the surface within a brush and moves nothing.
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
Result<int64_t> paint_dab(TriDexel& model, const Brush& brush, std::span<const Vec3> centres_mm,
                          std::span<const Material> materials);

}  // namespace kibori
