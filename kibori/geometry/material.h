// SPDX-License-Identifier: MIT
// The properties of a material. haptics/materials.h has the values of woods and other stock.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include <kibori/base/field_info.h>
#include <kibori/geometry/wood.h>

namespace kibori {

struct Material {
  std::string name = "material";
  double kf = 0.001;  // force for each removed lattice node [N], force model `paper`
  // Specific cutting energy: work per removed volume [N/mm^2 = N mm / mm^3]. Force models `energy`
  // and `series`.
  double u = 0.5;
  double c = 0;        // viscous part of the force [N s/mm^3], force model `series`
  double yield_n = 0;  // minimum force that cuts [N], force model `series`
  std::array<uint8_t, 3> color{196, 154, 108};
  // True for clay: a tool displaces the material instead of removing it (motion/reshape_stroke.h).
  bool plastic = false;
  // Work per area to split the material without removing any [N/mm = N mm / mm^2], see
  // body/cutter.h.
  double gc = 0.3;
  // Specific cutting energy along the grain [N/mm^2]. If it is given, u is the energy across the
  // grain. 0: u_along equals u.
  double u_along = 0;
  // Late wood of a year's ring resists more than early wood by this share of u (edit/grain.h).
  double ring = 0;
  // Specific resistance [N/mm^(2-m)] in the law of haptics/chip.h: for a cut through end grain,
  // along the fibres, and across them. All 0: this law is not used. The force is then u times the
  // cross-section of the chip.
  std::array<double, 3> k{0, 0, 0};
  double m = 0;              // exponent of the chip's thickness in this law, from 0 to below 1
  double density_kg_m3 = 0;  // 0: unknown
  LogCut log{};              // for wood; all materials of a model use one log (log_cut_of)

  static void for_fields(auto&& f) {
    constexpr FieldRange kNotNegative = FieldRange::not_negative;
    f(FieldInfo{"name", "name"}, &Material::name);
    f(FieldInfo{"kf", "kf", kNotNegative}, &Material::kf);
    f(FieldInfo{"u", "u", kNotNegative}, &Material::u);
    f(FieldInfo{"c", "c", kNotNegative}, &Material::c);
    f(FieldInfo{"yield_n", "yield_n", kNotNegative}, &Material::yield_n);
    f(FieldInfo{"color", "color", {}, Stored::always}, &Material::color);
    f(FieldInfo{"plastic", "plastic", {}, Stored::unless_default}, &Material::plastic);
    f(FieldInfo{"gc", "gc", kNotNegative, Stored::always}, &Material::gc);
    f(FieldInfo{"u_along", "u_along", kNotNegative, Stored::unless_default}, &Material::u_along);
    f(FieldInfo{"ring", "ring", kNotNegative, Stored::unless_default}, &Material::ring);
    f(FieldInfo{"k", "k", {}, Stored::unless_default}, &Material::k);
    f(FieldInfo{"m", "m", kNotNegative, Stored::unless_default}, &Material::m);
    f(FieldInfo{"density_kg_m3", "density", kNotNegative, Stored::always},
      &Material::density_kg_m3);
    f(FieldInfo{"log", "log", {}, Stored::unless_default}, &Material::log);
  }
  bool operator==(const Material&) const = default;
};

// Maximum of Material::ring. Early wood resists with u (1 - ring kMeanLate), see edit/grain.h. This
// is positive only for ring < 8. The limit leaves a margin.
inline constexpr double kMaxRing = 5;

// True if the law of haptics/chip.h gives the force, instead of u.
inline bool has_chip_law(const Material& m) { return m.k != std::array<double, 3>{0, 0, 0}; }
// True if the material's resistance depends on the direction of the cut.
inline bool has_direction(const Material& m) {
  if (has_chip_law(m)) return m.k[0] != m.k[1] || m.k[1] != m.k[2];
  return m.u_along > 0 && m.u_along != m.u;
}
// True if the material's resistance depends on the place or the direction of the cut.
inline bool has_grain(const Material& m) { return has_direction(m) || m.ring != 0; }
// Copies the log of the stock's material to all materials of a model. If `stock_material` is not an
// index into `materials`, nothing changes.
template <class Materials>
void share_log(Materials& materials, size_t stock_material) {
  if (!(stock_material < materials.size())) return;
  const LogCut log = materials[stock_material].log;
  for (Material& m : materials) m.log = log;
}
// Returns the log that a model uses: the log of the first material with a grain.
template <class Materials>
LogCut log_cut_of(const Materials& materials) {
  for (const Material& m : materials)
    if (has_grain(m)) return m.log;
  return {};
}
// Mean specific cutting energy [N/mm^2]. With the law of haptics/chip.h, it is the mean of the
// three k, for a chip that is 1 mm thick. Otherwise it is u.
inline double mean_cutting_energy(const Material& m) {
  return has_chip_law(m) ? (m.k[0] + m.k[1] + m.k[2]) / 3 : m.u;
}

// Makes the material resist with u in all directions and at all places.
inline void set_isotropic(Material& material, double u) {
  material.u = u;
  material.u_along = material.ring = material.m = 0;
  material.k = {0, 0, 0};
}

// Returns an error text if a number is invalid; null if all numbers are valid.
inline const char* fault_of(const Material& m) {
  for (const double x : {m.kf, m.u, m.c, m.yield_n, m.gc, m.u_along, m.ring, m.m, m.density_kg_m3,
                         m.k[0], m.k[1], m.k[2]})
    if (!(x >= 0 && x < 1e9)) return "a material's numbers must be from 0 to 1e9";
  if (!(m.log.ring_mm >= 0 && m.log.ring_mm < 1e6) || !m.log.axis.allFinite() ||
      !m.log.pith.allFinite())
    return "the ring width, axis and pith of a log must be finite numbers";
  if (m.ring > kMaxRing) return "ring must not exceed 5, or early wood would hardly resist";
  if (has_chip_law(m) && !(m.k[0] > 0 && m.k[1] > 0 && m.k[2] > 0))
    return "the three numbers of k must be greater than 0";
  if (!(m.m < 1)) return "m must be less than 1: thin chips would need the force of thick ones";
  if (m.m > 0 && !has_chip_law(m)) return "m needs k, because the law of u has no exponent";
  return nullptr;
}

}  // namespace kibori
