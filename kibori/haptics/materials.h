// SPDX-License-Identifier: MIT
// The materials that Kibori knows by name, with their physics: one table for scenes, documents and
// the studio.
#pragma once

#include <string>
#include <vector>

#include <kibori/haptics/force.h>

namespace kibori {

// A material and what its species is known for. Force models use `material`; its u is the one
// across the grain, as nothing feels the grain's direction yet.
struct Species {
  Material material;
  double u_along_n_mm2;  // specific cutting energy along the grain; of what has none, as across
  double density_kg_m3;  // woods: at 12 % moisture
};

// All of them, in the order in which a person is offered them; never empty.
const std::vector<Species>& known_species();
// Their materials, in the same order.
const std::vector<Material>& known_materials();

}  // namespace kibori
