// SPDX-License-Identifier: MIT
#include <kibori/reshape/mask_rule.h>

#include <algorithm>
#include <cmath>

namespace kibori {
namespace {

// The reach of a blur and of the measure of hollows [cells]. Hollows up to about this size are
// found.
constexpr double kBlurReach = 2.5, kHollowReach = 4;
// The hollowness that counts as fully hollow. The inner edge of a box has 0.35.
constexpr double kHollow = 0.25;
// Ends nearer than this [cells] are ignored, because their directions are mostly rounding error.
constexpr double kTooNear = 0.5;

uint64_t cube_key(int x, int y, int z) {
  const auto bits = [](int i) { return static_cast<uint64_t>(i + (1 << 20)) & 0x1fffff; };
  return bits(x) << 42 | bits(y) << 21 | bits(z);
}

}  // namespace

MaskRule::MaskRule(const TriDexel& model, const Brush& brush, const BrushPlaces& places)
    : brush_(brush), plane_point_(model.lattice().to_lattice(brush.plane.point_mm).units) {
  const bool blurs = brush.mask == MaskVerb::blur && brush.strength > 0;
  if (!blurs && brush.mask != MaskVerb::cavity) return;
  reach_ = blurs ? kBlurReach : kHollowReach;
  read(model, places);
}

void MaskRule::read(const TriDexel& model, BrushPlaces places) {
  places.radius += reach_;
  std::vector<std::pair<uint64_t, Near>> all;
  for_ends(model, places, [&](const PaintedEnd& end) {
    const auto cube = [&](int i) { return static_cast<int>(std::floor(end.at[i] / reach_)); };
    all.push_back({cube_key(cube(0), cube(1), cube(2)),
                   {end.at.cast<float>(), static_cast<float>(mask_of(end.color)) / kMaxMask}});
  });
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  near_.reserve(all.size());
  for (const auto& [key, near] : all) {
    const auto at = static_cast<uint32_t>(near_.size());
    cubes_.try_emplace(key, at, at).first->second.second = at + 1;
    near_.push_back(near);
  }
}

template <class F>
void MaskRule::for_near(const Vec3& at, F&& f) const {
  const auto cube = [&](int i) { return static_cast<int>(std::floor(at[i] / reach_)); };
  const int x0 = cube(0), y0 = cube(1), z0 = cube(2);
  for (int x = x0 - 1; x <= x0 + 1; x++)
    for (int y = y0 - 1; y <= y0 + 1; y++)
      for (int z = z0 - 1; z <= z0 + 1; z++) {
        const auto found = cubes_.find(cube_key(x, y, z));
        if (found == cubes_.end()) continue;
        for (uint32_t i = found->second.first; i < found->second.second; i++) {
          const double distance = (near_[i].at.cast<double>() - at).norm();
          if (distance < reach_) f(near_[i], distance);
        }
      }
}

double MaskRule::mean_mask(const PaintedEnd& end) const {
  double sum = 0, weights = 0;
  for_near(end.at, [&](const Near& near, double distance) {
    const double weight = 1 - distance * distance / (reach_ * reach_);
    sum += weight * static_cast<double>(near.mask);
    weights += weight;
  });
  return weights > 0 ? sum / weights : 0;
}

// How far the surface around an end is above the end's tangent plane: the mean sine of the angle to
// this plane, from -1 (a peak) to 1 (a hollow).
double MaskRule::hollowness(const PaintedEnd& end) const {
  const Vec3 normal = end.normal();
  double sum = 0;
  int count = 0;
  for_near(end.at, [&](const Near& near, double distance) {
    if (distance < kTooNear) return;
    sum += normal.dot(near.at.cast<double>() - end.at) / distance;
    count++;
  });
  return count > 0 ? sum / count : 0;
}

double MaskRule::wanted(const PaintedEnd& end) const {
  const double mask = static_cast<double>(mask_of(end.color)) / kMaxMask;
  const bool opposite = brush_.strength < 0;
  // The last three rules never reduce the mask.
  const auto also = [&](double more) { return std::max(mask, std::clamp(more, 0.0, 1.0)); };
  switch (brush_.mask) {
    case MaskVerb::paint:
      return opposite ? 0 : 1;
    case MaskVerb::invert:
      return 1 - mask;
    case MaskVerb::blur:  // its opposite: more contrast
      return opposite ? std::clamp(2 * mask - 0.5, 0.0, 1.0) : mean_mask(end);
    case MaskVerb::cavity:
      return also((opposite ? -1 : 1) * hollowness(end) / kHollow);
    case MaskVerb::height: {
      const double height = brush_.plane.normal.normalized().dot(end.at - plane_point_);
      return also(0.5 + (opposite ? -height : height));
    }
    case MaskVerb::material:
      return also((end.material == brush_.mask_material) != opposite ? 1 : 0);
  }
  return mask;
}

}  // namespace kibori
