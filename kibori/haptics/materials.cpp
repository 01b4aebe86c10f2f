// SPDX-License-Identifier: MIT
#include <kibori/haptics/materials.h>

#include <algorithm>
#include <cstdio>

namespace kibori {
namespace {

// Sources
//
// k and m of woods: B. Ettelt and H. J. Gittel, Saegen, Fraesen, Hobeln, Bohren (1987, 2004), with
//   Kivimaa's three directions (E. Kivimaa, Cutting Force in Woodworking, Helsinki 1950), as quoted
//   with page numbers in FreeCAD's material cards HardWood.FCMat and SoftWood.FCMat (CC-BY 3.0).
//   Published ranges [N/mm^1.5], A end grain / B along / C across:
//     oak    22-44 / 10  / 7        spruce 15-28 / 9 / 6
//     beech  26-40 / 12  / 7.5      balsa   4-9  / 6 / 3
//     pine   14-31 / 7.5 / 5        MDF    20-25 / not published
//   Our A is the middle of its range. MDF has no fibre direction: we use A in all directions.
//   Lime is beech and walnut is oak, scaled by density; neither was measured.
// Density of woods at 12 % moisture: Wood Handbook, FPL-GTR-282 (2021), table 5-3b, and
//   EN 350:2016.
// ring: density of a ring's late wood divided by that of its early wood, minus 1. The quotient is 2
//   to 3 in conifers, 1.5 or more in ring-porous oak, and nearly 1 in diffuse-porous beech and lime
//   (Wood Handbook, chapter 3).
// ring_mm: usual widths of European timber, 1 to 4 mm; balsa grows about 8 mm in a year.
// yield_n: length of a carver's edge (a few mm) times the force of a sharp edge per mm. This force
//   is 0.1 to 0.2 N in these woods (P. Koch, Wood Machining Processes, 1964).
// gc: I. Smith, E. Landis and M. Gong, Fracture and Fatigue in Wood (2003): 0.1 to 0.6 N/mm if a
//   wedge opens a crack along the grain.
// Wax, clay, foam: published values differ by up to a factor of ten; we use middle values.
// Bone: orthogonal cutting of cortical bone, C. H. Jacobs et al., J. Biomechanics 7 (1974) 131, and
//   K. L. Wiggins and S. Malkin, J. Biomech. Eng. 100 (1978) 122: some tens to 150 N/mm^2.
//   Trabecular bone is scaled by the square of its density, as its strength is (Carter and Hayes
//   1977).
// Acrylic (PMMA): 80 to 150 N/mm^2 in orthogonal cutting. Dentine and enamel are acrylic scaled by
//   Martens hardness (180, 468 and 2264 N/mm^2: Dentistry Journal 12 (2024) 1, table 2). Plaster
//   and machinable wax: estimates from their strength. Expect errors of a factor of two here.
// kf (force model `paper`, N per point) has no physical counterpart, and the paper gives no value.
//   We set it in proportion to u.
Material wood(const char* name, std::array<double, 3> k, double density, double ring,
              double ring_mm, double gc, std::array<uint8_t, 3> color) {
  Material material;
  material.name = name;
  material.k = k;
  material.m = 0.5;
  material.u = mean_cutting_energy(material);
  material.kf = 6e-5 * material.u;
  material.c = 2e-6 * material.u;
  material.yield_n = 0.06 * k[1];
  material.density_kg_m3 = density;
  material.ring = ring;
  material.log.ring_mm = ring_mm;
  material.gc = gc;
  material.color = color;
  return material;
}

Material even(const char* name, double u, double density, double yield_n, double gc,
              std::array<uint8_t, 3> color) {
  Material material;
  material.name = name;
  material.u = u;
  material.kf = 6e-5 * u;
  material.c = 2e-6 * u;
  material.yield_n = yield_n;
  material.density_kg_m3 = density;
  material.gc = gc;
  material.color = color;
  return material;
}

std::vector<Material> make_materials() {
  std::vector<Material> all = {
      wood("limewood", {24, 8.8, 5.5}, 530, 0.2, 2.5, 0.3, {214, 178, 130}),
      wood("pine", {22, 7.5, 5}, 510, 1.2, 2.5, 0.25, {222, 184, 135}),
      wood("spruce", {21, 9, 6}, 450, 1.2, 2, 0.25, {228, 196, 150}),
      wood("walnut", {28, 8.5, 6}, 610, 0.5, 3, 0.4, {121, 83, 54}),
      wood("oak", {33, 10, 7}, 720, 0.8, 2, 0.5, {184, 134, 84}),
      wood("beech", {33, 12, 7.5}, 720, 0.2, 2, 0.5, {205, 160, 120}),
      wood("balsa", {6, 6, 3}, 160, 0.2, 8, 0.1, {237, 211, 165}),
      wood("MDF", {22, 22, 22}, 750, 0, 0, 0.3, {180, 148, 110}),
      even("wax", 2, 930, 0.1, 0.1, {226, 214, 190}),
      even("machinable wax", 8, 920, 0.2, 0.2, {70, 105, 175}),
      even("clay", 1, 1700, 0.1, 0.05, {168, 110, 84}),
      even("foam", 0.5, 40, 0.05, 0.1, {190, 205, 215}),
      even("plaster", 10, 1200, 0.3, 0.05, {236, 234, 228}),
      even("acrylic", 100, 1190, 1, 1, {205, 225, 235}),
      even("cortical bone", 70, 1900, 1, 1.5, {232, 222, 196}),
      even("trabecular bone", 4, 450, 0.2, 0.3, {226, 200, 170}),
      even("dentine", 260, 2150, 1, 0.3, {224, 202, 150}),
      even("enamel", 1250, 2950, 2, 0.1, {240, 238, 228}),
  };
  const auto named = [&](std::string_view name) -> Material& {
    return *std::find_if(all.begin(), all.end(), [&](const Material& m) { return m.name == name; });
  };
  named("clay").plastic = true;
  // Soft materials stick to the tool: their resistance grows with its speed.
  named("wax").c = 5e-5;
  named("clay").c = 1e-4;
  named("foam").c = 1e-5;
  return all;
}

}  // namespace

const std::vector<Material>& known_materials() {
  static const std::vector<Material> list = make_materials();
  return list;
}

std::string law_text(const Material& m) {
  char text[120];
  if (!has_chip_law(m) && has_direction(m))
    std::snprintf(text, sizeof text, "%g along, %g across, N/mm²", m.u_along, m.u);
  else if (!has_chip_law(m))
    std::snprintf(text, sizeof text, "%g N/mm²", m.u);
  else if (has_direction(m))
    std::snprintf(text, sizeof text, "%g / %g / %g N/mm^%g", m.k[0], m.k[1], m.k[2], 2 - m.m);
  else
    std::snprintf(text, sizeof text, "%g N/mm^%g", m.k[0], 2 - m.m);
  return text;
}

const Material* known_material(std::string_view name) {
  for (const Material& material : known_materials())
    if (material.name == name) return &material;
  return nullptr;
}

}  // namespace kibori
