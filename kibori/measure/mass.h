// SPDX-License-Identifier: MIT
// What a model weighs, and where its centre of gravity is.
#pragma once

#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

struct MassProperties {
  std::vector<double> volume_mm3;  // of each material; the mean of the three fields
  double mass_g = 0;               // 0 where a density is not known
  // Of gravity, in the model's own coordinates [mm]; where a density is not known, of volume. Zero
  // of what is empty.
  Vec3 centre_mm = Vec3::Zero();
};

// `density_kg_m3`: of each material, 0 where it is not known; there must be one for each that the
// model holds, as the last stands for all beyond it.
MassProperties mass_of(const Snapshot& model, const std::vector<double>& density_kg_m3);

}  // namespace kibori
