// SPDX-License-Identifier: MIT
#include <kibori/picture/wood.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>
#include <utility>

#include <kibori/picture/picture.h>

namespace kibori {
double ring_contrast(std::string_view material) {
  std::string name(material);
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  // The first entry whose text is a part of the name counts ("limestone" is a stone).
  static constexpr std::pair<std::string_view, double> kContrasts[] = {
      {"stone", 0},   {"wax", 0},     {"clay", 0},        {"foam", 0},     {"plaster", 0},
      {"acrylic", 0}, {"mdf", 0},     {"enamel", 0},      {"dentin", 0},   {"pulp", 0},
      {"bone", 0},    {"lime", 0.12}, {"basswood", 0.12}, {"balsa", 0.25}, {"walnut", 0.6},
      {"oak", 1},     {"pine", 1},    {"spruce", 0.9},    {"beech", 0.15}};
  for (const auto& [part, contrast] : kContrasts)
    if (name.find(part) != std::string::npos) return contrast;
  return 0.5;
}

WoodPoint wood_at(const Log& log, const Vec3& point) {
  const Vec3 from = point - log.pith;
  const double along = from.dot(log.along);
  const Vec3 across = from - along * log.along;
  const double rings = rings_at(log, point, ring_wave(log, point)), year = std::floor(rings);
  const double ring = late_wood(rings);
  // Fibres: long and thin along the trunk.
  const Vec3 stretched = across / (0.11 * log.ring) + log.along * (along / (3.5 * log.ring));
  const double fibre = value_noise(stretched);
  const double patch = value_noise(from / (9 * log.ring) + Vec3(31, 17, 5));
  const double strength = 0.65 + 0.25 * corner_value(static_cast<int>(year), 1, 9);
  const double dark = std::clamp(strength * ring + 0.13 * fibre + 0.1 * patch + 0.12, 0.0, 1.0);
  return {dark, 0.6 - 0.3 * dark + 0.1 * fibre};
}

}  // namespace kibori
