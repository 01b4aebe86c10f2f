// SPDX-License-Identifier: MIT
#include <kibori/haptics/materials.h>

namespace kibori {

// Sources.
//  - Density of the woods: Forest Products Laboratory, Wood Handbook, FPL-GTR-282 (2021), table
//    5-3b (basswood, black walnut, white oak, balsa), and EN 350:2016 (lime, Scots pine).
//  - Specific cutting energy u: E. Kivimaa, Cutting Force in Woodworking (Helsinki 1950), and P.
//    Koch, Wood Machining Processes (1964): for chips of some tenths of a mm the main cutting force
//    across the grain (90-90) is 10 ... 40 N for each mm^2 of chip in woods of 500 ... 700 kg/m^3,
//    rises about in proportion to the density and falls by half along the grain (90-0). The values
//    here are rounded from that; a single wood differs from them by a third.
//  - Late wood of a ring is denser than its early wood: in conifers two to three times, in
//  ring-porous
//    oak by half and more, in diffuse-porous lime hardly (Wood Handbook, chapter 3); u goes with
//    it.
//  - Yield (the least force at which a carver's tool begins to cut): of the order of the edge's
//    length (some mm) times what a sharp edge needs for each mm of it, 0.1 ... 0.2 N in these woods
//    (Koch).
//  - Fracture energy gc: I. Smith, E. Landis and M. Gong, Fracture and Fatigue in Wood (2003): 0.1
//  ...
//    0.6 N/mm where a crack runs along the grain, as a wedge splits; across it, some tens of times
//    as much.
//  - Wax, clay and foam: indentation and cutting tests of modelling materials scatter by an order
//    of magnitude; these are values of the middle.
// kf (force model `paper`, N for each point) has no counterpart in nature: the paper leaves it
// open. It is in proportion to u.
const std::vector<Species>& known_species() {
  static const std::vector<Species> list = {
      {{"limewood", 0.0005, 11, 0.00002, 0.5, {214, 178, 130}, false, 0.3, 5.5, 0.2}, 530},
      {{"pine", 0.0006, 12, 0.00002, 0.6, {222, 184, 135}, false, 0.25, 6, 1.2}, 510},
      {{"walnut", 0.0009, 20, 0.00003, 0.9, {121, 83, 54}, false, 0.4, 10, 0.5}, 610},
      {{"oak", 0.001, 25, 0.00003, 1.0, {184, 134, 84}, false, 0.5, 12, 0.8}, 720},
      {{"balsa", 0.0002, 3, 0.00001, 0.2, {237, 211, 165}, false, 0.1, 1.5, 0.2}, 160},
      {{"wax", 0.0002, 2, 0.00005, 0.1, {226, 214, 190}, false, 0.1}, 930},
      {{"clay", 0.0002, 1, 0.0001, 0.1, {168, 110, 84}, true, 0.05}, 1700},
      {{"foam", 0.0001, 0.5, 0.00001, 0.05, {190, 205, 215}, false, 0.1}, 40},
  };
  return list;
}

double density_of(std::string_view name) {
  for (const Species& species : known_species())
    if (species.material.name == name) return species.density_kg_m3;
  return 0;
}

const std::vector<Material>& known_materials() {
  static const std::vector<Material> list = [] {
    std::vector<Material> all;
    for (const Species& species : known_species()) all.push_back(species.material);
    return all;
  }();
  return list;
}

}  // namespace kibori
