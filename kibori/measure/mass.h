// SPDX-License-Identifier: MIT
// Mass and centre of gravity of a model.
#pragma once

#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

struct MassProperties {
  // Volume of each material (dexel/volume.h), with as many entries as `density_kg_m3`. The last
  // entry includes all materials beyond the list.
  std::vector<double> volume_mm3;
  double mass_g = 0;  // 0 if the density of a material in the model is unknown
  // Centre of gravity, in the model's coordinates [mm]. If a density is unknown, it is the centroid
  // of the volume. It is zero for an empty model.
  Vec3 centre_mm = Vec3::Zero();
};

// `density_kg_m3` has the density of each material; 0 means unknown. It must not be empty. Its last
// value also counts for all materials beyond the list.
MassProperties mass_of(const Snapshot& model, const std::vector<double>& density_kg_m3);

}  // namespace kibori
