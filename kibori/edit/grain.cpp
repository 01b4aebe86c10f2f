// SPDX-License-Identifier: MIT
#include <kibori/edit/grain.h>

#include <algorithm>
#include <cmath>

namespace kibori {
namespace {

// Nodes of the coarse grid along the lattice's longest side: rings there are 26, and their waves
// five of them long at least, so that a wave has twelve.
constexpr int kNodes = 64;
// Parts of a piece, in rings; and so many at most. Longer, and the dark rim of a ring, a third of
// it, is met by chance.
constexpr double kPart = 0.1;
constexpr int kMostParts = 128;

}  // namespace

std::shared_ptr<const Grain> Grain::of(const Lattice& lattice,
                                       const std::vector<Material>& materials) {
  if (std::none_of(materials.begin(), materials.end(), has_grain)) return nullptr;
  return std::make_shared<const Grain>(log_of(lattice.to_mm(lattice.whole())), lattice, materials);
}

Grain::Grain(const Log& log, const Lattice& lattice, const std::vector<Material>& materials)
    : log_(log) {
  log_.pith = lattice.to_lattice(log.pith).units;
  log_.ring = log.ring / lattice.pitch_mm;
  kinds_.reserve(materials.size() + 1);
  for (const Material& m : materials)
    kinds_.push_back({has_grain(m), m.u_along > 0 && m.u > 0 ? m.u_along / m.u : 1, m.ring});
  if (kinds_.empty()) kinds_.emplace_back();
  step_ = static_cast<double>(lattice.nodes.maxCoeff()) / kNodes;
  for (int i = 0; i < 3; i++) count_[i] = static_cast<int>(std::ceil(lattice.nodes[i] / step_)) + 2;
  waves_.reserve(static_cast<size_t>(count_.prod()));
  for (int z = 0; z < count_[2]; z++)
    for (int y = 0; y < count_[1]; y++)
      for (int x = 0; x < count_[0]; x++)
        waves_.push_back(static_cast<float>(ring_wave(log_, step_ * Vec3(x, y, z))));
}

double Grain::rings(const Vec3& units) const {
  Index3 at;
  Vec3 part;
  for (int i = 0; i < 3; i++) {
    const double place = units[i] / step_;
    at[i] = std::clamp(static_cast<int>(place), 0, count_[i] - 2);
    part[i] = std::clamp(place - at[i], 0.0, 1.0);
  }
  const float* const from =
      waves_.data() +
      (static_cast<size_t>(at[2]) * static_cast<size_t>(count_[1]) + static_cast<size_t>(at[1])) *
          static_cast<size_t>(count_[0]) +
      static_cast<size_t>(at[0]);
  const size_t row = static_cast<size_t>(count_[0]), plane = row * static_cast<size_t>(count_[1]);
  const auto mix = [](double a, double b, double share) { return a + share * (b - a); };
  const auto line = [&](const float* p) { return mix(p[0], p[1], part[0]); };
  const auto face = [&](const float* p) { return mix(line(p), line(p + row), part[1]); };
  return rings_at(log_, units, mix(face(from), face(from + plane), part[2]));
}

double Grain::by_ring(uint8_t material, Axis axis, double u, double v, double lo, double hi) const {
  const double ring = kind(material).ring;
  if (ring == 0) return 1;
  const double length = hi - lo;
  const int parts =
      std::clamp(static_cast<int>(std::ceil(length / (kPart * log_.ring))), 1, kMostParts);
  Vec3 at;
  at[u_index(axis)] = u;
  at[v_index(axis)] = v;
  double late = 0;
  for (int i = 0; i < parts; i++) {
    at[depth_index(axis)] = lo + length * (i + 0.5) / parts;
    late += late_wood(rings(at));
  }
  return 1 + ring * (late / parts - kMeanLate);
}

}  // namespace kibori
