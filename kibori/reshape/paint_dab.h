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

// Blends the brush's colour into every end of the surface within it, by strength times falloff;
// what was never painted has its material's colour before. Falloffs about several places add up to
// 1 at most. Gives the number of ends that have another colour now. `materials`: not empty; one
// that is not in it is as the last. Errors: a brush that check_brush refuses, a place that is not
// finite.
Result<int64_t> paint_dab(TriDexel& model, const Brush& brush, std::span<const Vec3> centres_mm,
                          std::span<const Material> materials);

}  // namespace kibori
