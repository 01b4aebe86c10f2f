// SPDX-License-Identifier: MIT
#include <kibori/picture/wood.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include <kibori/picture/picture.h>

namespace kibori {
namespace {

// A number in [0, 1) for a corner of the integer lattice.
double corner_value(int x, int y, int z) {
  uint32_t h = static_cast<uint32_t>(x) * 0x8da6b343u ^ static_cast<uint32_t>(y) * 0xd8163841u ^
               static_cast<uint32_t>(z) * 0xcb1ab31fu;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 12;
  h *= 0x297a2d39u;
  h ^= h >> 15;
  return h * 0x1p-32;
}

// Smooth value noise in [-1, 1], one bump a unit.
double noise(const Vec3& p) {
  const Vec3 floor = p.array().floor();
  const Vec3 f = p - floor;
  const Vec3 s = f.array() * f.array() * (3 - 2 * f.array());
  const int x = static_cast<int>(floor.x()), y = static_cast<int>(floor.y()),
            z = static_cast<int>(floor.z());
  double sum = 0;
  for (int c = 0; c < 8; c++) {
    const double weight =
        (c & 1 ? s.x() : 1 - s.x()) * (c & 2 ? s.y() : 1 - s.y()) * (c & 4 ? s.z() : 1 - s.z());
    sum += weight * corner_value(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
  }
  return 2 * sum - 1;
}

}  // namespace

double ring_contrast(std::string_view material) {
  std::string name(material);
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  // By a part of the name; what comes first counts ("limestone" is a stone).
  static constexpr std::pair<std::string_view, double> kContrasts[] = {
      {"stone", 0},    {"wax", 0},     {"clay", 0},        {"foam", 0},
      {"plaster", 0},  {"lime", 0.12}, {"basswood", 0.12}, {"balsa", 0.25},
      {"walnut", 0.6}, {"oak", 1},     {"pine", 1}};
  for (const auto& [part, contrast] : kContrasts)
    if (name.find(part) != std::string::npos) return contrast;
  return 0.5;
}

WoodPoint wood_at(const Log& log, const Vec3& point) {
  const Vec3 from = point - log.pith;
  const double along = from.dot(log.along);
  const Vec3 across = from - along * log.along;
  // Trees are not round, nor straight: slow bends along the trunk, waves around it.
  const Vec3 bend = Vec3(along, across.norm(), 0) / (40 * log.ring);
  const double wave =
      noise(from / (14 * log.ring)) * 1.1 + noise(from / (5 * log.ring)) * 0.12 + noise(bend) * 1.5;
  const double rings = across.norm() / log.ring + wave;
  const double year = std::floor(rings), part = rings - year;
  // Early wood grows dark slowly, and ends at once.
  const double width = 0.55 + 0.3 * corner_value(static_cast<int>(year), 7, 3);
  const double late = std::clamp((part - width) / (1 - width), 0.0, 1.0);
  const double edge = std::clamp((1 - part) / 0.06, 0.0, 1.0);
  const double ring = late * late * (3 - 2 * late) * edge;
  // Fibres: long and thin along the trunk.
  const Vec3 stretched = across / (0.11 * log.ring) + log.along * (along / (3.5 * log.ring));
  const double fibre = noise(stretched);
  const double patch = noise(from / (9 * log.ring) + Vec3(31, 17, 5));
  const double strength = 0.65 + 0.25 * corner_value(static_cast<int>(year), 1, 9);
  const double dark = std::clamp(strength * ring + 0.13 * fibre + 0.1 * patch + 0.12, 0.0, 1.0);
  return {dark, 0.6 - 0.3 * dark + 0.1 * fibre};
}

}  // namespace kibori
