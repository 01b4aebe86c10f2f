// SPDX-License-Identifier: MIT
// What a part of a model is made of. haptics/materials.h has the values of woods and other stock.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include <kibori/base/field_info.h>

namespace kibori {

struct Material {
  std::string name = "material";
  double kf = 0.001;  // N per point, force model `paper`
  // Specific cutting energy [N/mm^2 = N mm / mm^3], force models `energy` and `series`.
  double u = 0.5;
  double c = 0;        // viscous part of the force [N s/mm^3], force model `series`
  double yield_n = 0;  // least force that cuts [N], force model `series`
  std::array<uint8_t, 3> color{196, 154, 108};
  // What a cut pushes away stays, around the tool: mode `press` (motion/reshape_stroke.h).
  bool plastic = false;
  // What it takes to part it without removing any [N/mm = N mm / mm^2]: body/cutter.h.
  double gc = 0.3;
  // Specific cutting energy along the grain [N/mm^2], where u is that across it; 0: as across.
  double u_along = 0;
  // By what share of u late wood of a year's ring resists more than early wood (edit/grain.h).
  double ring = 0;

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
  }
  bool operator==(const Material&) const = default;
};

// More, and early wood would resist less than nothing (see kMeanLate).
inline constexpr double kMaxRing = 5;

// Whether it matters where, and which way, it is cut.
inline bool has_grain(const Material& m) {
  return (m.u_along > 0 && m.u_along != m.u) || m.ring != 0;
}

}  // namespace kibori
