// SPDX-License-Identifier: MIT
#include <kibori/reshape/warp_map.h>

#include <algorithm>
#include <cmath>

#include <kibori/base/trig.h>

namespace kibori {
namespace {

// Step of a grab [radii]. (1 - r^2)^2 falls by at most 1.54 per radius, so a step of 0.65 folds the
// surface.
constexpr double kGrabStep = 0.5;
// Step of a hook [radii]. (1 - r^4)^2 falls by at most 2.42 per radius.
constexpr double kHookStep = 0.3;
// Step of a divergence-free grab [radii]. Each step is one of the classical Runge-Kutta method.
constexpr double kFlowStep = 0.1;
// A step of scale changes lengths by at most this factor. At 2.25, the surface folds.
constexpr double kScaleStep = 1.5;
constexpr double kMinScale = 0.02, kLargestScale = 50;

}  // namespace

bool GrabReach::holds(const Vec3& point) const {
  const Vec3 way = to - from;
  const double length2 = way.squaredNorm();
  const double share = length2 > 0 ? std::clamp((point - from).dot(way) / length2, 0.0, 1.0) : 0.0;
  return (point - from - share * way).squaredNorm() < radius * radius;
}

WarpMap::WarpMap(WarpVerb verb, const Brush& brush, double radius, const Drag& drag)
    : verb_(verb),
      falloff_(brush.falloff),
      radius_(radius),
      centre_(drag.centre),
      normal_(drag.normal) {
  const double displacement = drag.displacement.norm(), strength = brush.strength;
  reach_.include(centre_);
  switch (verb) {
    case WarpVerb::grab:
    case WarpVerb::grab_connected:
    case WarpVerb::hook:
    case WarpVerb::nudge: {
      displacement_ = strength * drag.displacement;
      if (verb == WarpVerb::nudge) displacement_ -= displacement_.dot(drag.normal) * drag.normal;
      keep_volume_ = brush.keep_volume && (verb == WarpVerb::grab || verb == WarpVerb::nudge);
      const double length = displacement_.norm();
      idle_ = !(length > 0);
      if (idle_) break;
      const double max_step = radius * (keep_volume_             ? kFlowStep
                                        : verb == WarpVerb::hook ? kHookStep
                                                                 : kGrabStep);
      steps_ = static_cast<int>(std::floor(length / max_step));
      step_ = displacement_ / length * max_step;
      rest_ = displacement_ - steps_ * step_;
      // A step moves no point out of its ball, so the ball of the last step is enough. But with a
      // constant falloff or in a flow, the points move with the ball, also in the last step.
      reach_.include(falloff_ == Falloff::constant || keep_volume_
                         ? Vec3(centre_ + displacement_)
                         : Vec3(centre_ + displacement_ - rest_));
      break;
    }
    case WarpVerb::twist:
      turn_axis_ = drag.axis;
      amount_ = strength * drag.turn_rad;
      idle_ = amount_ == 0;
      break;
    case WarpVerb::bend: {
      turn_axis_ = drag.axis.cross(drag.displacement);
      const double across = turn_axis_.norm();
      idle_ = !(across > 1e-9 * displacement) || displacement == 0;
      if (idle_) break;
      turn_axis_ /= across;
      amount_ = strength * displacement / radius;
      break;
    }
    case WarpVerb::pinch:
      amount_ = strength * displacement / (radius + displacement);
      idle_ = amount_ == 0;
      break;
    case WarpVerb::scale: {
      amount_ = std::clamp(1 + strength * drag.displacement.dot(drag.axis) / radius, kMinScale,
                           kLargestScale);
      idle_ = amount_ == 1;
      // Divides the factor into many equal steps, each of which is a root of it.
      for (steps_ = 1; amount_ > kScaleStep || amount_ < 1 / kScaleStep; steps_ *= 2)
        amount_ = std::sqrt(amount_);
      break;
    }
    case WarpVerb::node:
      break;
  }
  reach_ = reach_.grown(radius);
}

Vec3 WarpMap::flow(const Vec3& point) const {
  Vec3 centre = centre_;
  Vec3 x = point + falloff_weight(Falloff::smooth, (point - centre).norm() / radius_) * lift_;
  const double r2 = radius_ * radius_;
  const auto along = [&](const Vec3& at, const Vec3& about, const Vec3& d) -> Vec3 {
    const Vec3 y = at - about;
    const double rho2 = y.squaredNorm() / r2;
    if (!(rho2 < 1)) return Vec3::Zero();
    const double w = (1 - rho2) * (1 - rho2);
    return w * ((1 - 4 * rho2) * d + 3 * d.dot(y) / r2 * y);
  };
  for (int i = 0; i <= steps_; i++) {
    const Vec3& d = i < steps_ ? step_ : rest_;
    const Vec3 half = centre + 0.5 * d, end = centre + d;
    const Vec3 k1 = along(x, centre, d), k2 = along(x + 0.5 * k1, half, d),
               k3 = along(x + 0.5 * k2, half, d), k4 = along(x + k3, end, d);
    x += (k1 + 2 * k2 + 2 * k3 + k4) / 6;
    centre = end;
  }
  return x;
}

Vec3 WarpMap::operator()(const Vec3& point) const {
  if (idle_) return point;
  Vec3 y = point - centre_;
  switch (verb_) {
    case WarpVerb::grab:
    case WarpVerb::grab_connected:
    case WarpVerb::hook:
    case WarpVerb::nudge: {
      if (keep_volume_) return flow(point);
      Vec3 x = point, centre = centre_;
      for (int i = 0; i < steps_; i++) {
        x += weight(x - centre) * step_;
        centre += step_;
      }
      return x + weight(x - centre) * rest_;
    }
    case WarpVerb::twist:
    case WarpVerb::bend: {
      const double w = weight(y);
      if (w == 0) return point;
      const auto [sine, cosine] = sin_cos(w * amount_);
      const Vec3 along = turn_axis_.dot(y) * turn_axis_, across = y - along;
      return centre_ + along + cosine * across + sine * turn_axis_.cross(across);
    }
    case WarpVerb::pinch:
      return centre_ + (1 - amount_ * weight(y)) * y;
    case WarpVerb::scale:
      for (int i = 0; i < steps_; i++) y *= 1 + (amount_ - 1) * weight(y);
      return centre_ + y;
    case WarpVerb::node:
      break;
  }
  return point;
}

}  // namespace kibori
