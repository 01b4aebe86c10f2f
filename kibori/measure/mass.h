// SPDX-License-Identifier: MIT
// Mass and centre of gravity of a model.
#pragma once

#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

struct MassProperties {
  std::vector<double> volume_mm3;  // of each material (dexel/volume.h)
  double mass_g = 0;               // 0 if a density is unknown
  // Centre of gravity, in the model's own coordinates [mm]. If a density is unknown, it is the
  // centroid of the volume. Zero for an empty model.
  Vec3 centre_mm = Vec3::Zero();
};

// `density_kg_m3`: of each material, 0 if unknown; not empty. The last value counts for all
// materials beyond the list.
MassProperties mass_of(const Snapshot& model, const std::vector<double>& density_kg_m3);

}  // namespace kibori
