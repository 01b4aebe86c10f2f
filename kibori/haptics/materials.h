// SPDX-License-Identifier: MIT
// The materials that Kibori knows by name, with their physics: one table for scenes, documents and
// the studio.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/haptics/force.h>

namespace kibori {

// A material and what its species is known for. Force models use `material`. Its u is that across
// the grain: the mean of 0-90 and 90-90 in wood science's names for cutting directions, which
// motion alone can't tell apart; u_along is that of 90-0.
struct Species {
  Material material;
  double density_kg_m3;  // woods: at 12 % moisture
};

// All of them, in the order in which a person is offered them; never empty.
const std::vector<Species>& known_species();
// Their materials, in the same order.
const std::vector<Material>& known_materials();
// Of the known one of that name [kg/m^3]; 0: there is none.
double density_of(std::string_view name);

}  // namespace kibori
