// SPDX-License-Identifier: MIT
#include <kibori/geometry/wood.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace kibori {

namespace {

constexpr uint32_t kHashX = 0x8da6b343u, kHashY = 0xd8163841u, kHashZ = 0xcb1ab31fu;

double value_of_hash(uint32_t h) {
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 12;
  h *= 0x297a2d39u;
  h ^= h >> 15;
  return h * 0x1p-32;
}

}  // namespace

double corner_value(int x, int y, int z) {
  return value_of_hash(static_cast<uint32_t>(x) * kHashX ^ static_cast<uint32_t>(y) * kHashY ^
                       static_cast<uint32_t>(z) * kHashZ);
}

double value_noise(const Vec3& p) {
  constexpr uint32_t kHashes[3] = {kHashX, kHashY, kHashZ};
  uint32_t hashes[3][2];  // per axis, of the lower and the upper corners
  double weights[3][2];
  for (int i = 0; i < 3; i++) {
    int floor = static_cast<int>(p[i]);  // std::floor is a function call on x86-64
    floor -= p[i] < floor;
    const double f = p[i] - floor, s = f * f * (3 - 2 * f);
    weights[i][0] = 1 - s;
    weights[i][1] = s;
    hashes[i][0] = static_cast<uint32_t>(floor) * kHashes[i];
    hashes[i][1] = hashes[i][0] + kHashes[i];
  }
  double sum = 0;
  for (int c = 0; c < 8; c++) {
    const int x = c & 1, y = c >> 1 & 1, z = c >> 2;
    sum += weights[0][x] * weights[1][y] * weights[2][z] *
           value_of_hash(hashes[0][x] ^ hashes[1][y] ^ hashes[2][z]);
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
