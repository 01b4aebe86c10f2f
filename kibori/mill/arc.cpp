// SPDX-License-Identifier: MIT
#include <kibori/mill/arc.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <kibori/base/trig.h>

namespace kibori {
namespace {

// A smaller angle [rad] between start and end is a full circle, as in LinuxCNC.
constexpr double kFullCircle = 1e-6;
// Maximum number of chords of one arc. Only a damaged file has an arc that needs more.
constexpr double kMaxChords = 1e6;
constexpr double kTurn = 2 * std::numbers::pi;

}  // namespace

ArcPath::ArcPath(const Vec3& from_mm, const ArcMove& arc)
    : from_(from_mm), to_(arc.to.xyz_mm), centre_(arc.centre_mm), axes_(axes_of(arc.plane)) {
  const int u = axes_.first, v = axes_.second;
  const double su = from_[u] - centre_[u], sv = from_[v] - centre_[v];
  const double eu = to_[u] - centre_[u], ev = to_[v] - centre_[v];
  start_radius_ = std::hypot(su, sv);
  end_radius_ = std::hypot(eu, ev);
  start_angle_ = std::atan2(sv, su);
  const bool ccw = arc.turns > 0;
  double sweep = std::atan2(ev, eu) - start_angle_;
  if (!ccw) sweep = -sweep;
  while (sweep <= kFullCircle) sweep += kTurn;
  while (sweep > kTurn + kFullCircle) sweep -= kTurn;
  sweep += kTurn * (std::abs(arc.turns) - 1);
  sweep_ = ccw ? sweep : -sweep;
}

Vec3 ArcPath::at(double share) const {
  if (share <= 0) return from_;
  if (share >= 1) return to_;
  const double radius = start_radius_ + share * (end_radius_ - start_radius_);
  const double turned = start_angle_ + share * sweep_;
  const SinCos angle = sin_cos(turned - kTurn * std::floor(turned / kTurn));
  Vec3 point;
  point[axes_.first] = centre_[axes_.first] + radius * angle.cos;
  point[axes_.second] = centre_[axes_.second] + radius * angle.sin;
  point[axes_.normal] = from_[axes_.normal] + share * (to_[axes_.normal] - from_[axes_.normal]);
  return point;
}

double ArcPath::radius_mm() const { return std::max(start_radius_, end_radius_); }

double ArcPath::length_mm() const {
  return std::hypot(0.5 * (start_radius_ + end_radius_) * sweep_,
                    to_[axes_.normal] - from_[axes_.normal]);
}

int ArcPath::chords(double sagitta_mm) const {
  const double radius = radius_mm();
  if (!(radius > 0)) return 1;
  // The sagitta of a chord of angle a is r (1 - cos(a / 2)).
  const double cosine = std::max(0.0, 1 - sagitta_mm / radius);
  const double widest = 2 * std::acos(cosine);
  if (!(widest > 0)) return static_cast<int>(kMaxChords);
  return static_cast<int>(std::clamp(std::ceil(std::abs(sweep_) / widest), 1.0, kMaxChords));
}

}  // namespace kibori
