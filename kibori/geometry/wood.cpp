// SPDX-License-Identifier: MIT
#include <kibori/geometry/wood.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace kibori {

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

double value_noise(const Vec3& p) {
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

Log log_of(const Box& plank, const LogCut& cut) {
  Log log;
  int longest = 0;
  plank.size().maxCoeff(&longest);
  log.along = Vec3(Vec3::Unit(longest) + Vec3(0.05, 0.09, 0.06)).normalized();
  Vec3 aside = Vec3(0.31, 0.55, -0.77);
  aside = Vec3(aside - aside.dot(log.along) * log.along).normalized();
  const double u = plank.size()[(longest + 1) % 3], v = plank.size()[(longest + 2) % 3];
  const bool round = std::abs(u - v) < 0.02 * u;
  log.pith =
      plank.centre() +
      (round ? 0.06 * u : 0.45 * plank.size().minCoeff() + 0.12 * plank.size().norm()) * aside;
  if (!cut.axis.isZero(0)) {
    log.along = cut.axis.normalized();
    log.pith = cut.pith;
  }
  log.ring = cut.ring_mm > 0 ? cut.ring_mm : plank.size().maxCoeff() / 26;
  return log;
}

double ring_wave(const Log& log, const Vec3& point) {
  const Vec3 from = point - log.pith;
  const double along = from.dot(log.along);
  const Vec3 across = from - along * log.along;
  const Vec3 bend = Vec3(along, across.norm(), 0) / (40 * log.ring);
  return value_noise(from / (14 * log.ring)) * 1.1 + value_noise(from / (5 * log.ring)) * 0.12 +
         value_noise(bend) * 1.5;
}

double early_wood(double year) { return 0.55 + 0.3 * corner_value(static_cast<int>(year), 7, 3); }

double late_wood(double rings) {
  const double year = std::floor(rings), part = rings - year, early = early_wood(year);
  const double late = std::clamp((part - early) / (1 - early), 0.0, 1.0);
  const double edge = std::clamp((1 - part) / kRingEdge, 0.0, 1.0);
  return late * late * (3 - 2 * late) * edge;
}

}  // namespace kibori
