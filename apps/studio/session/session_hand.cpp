// SPDX-License-Identifier: MIT
#include "apps/studio/session/session_hand.h"

#include <cmath>

namespace kibori {

std::optional<Pose> SessionHand::pose_of(const Vec3& tip_mm, const Vec3& axis, bool upright) {
  const double length = std::sqrt(axis.squaredNorm());
  if (!tip_mm.allFinite() || !(length > 1e-9) || !std::isfinite(length)) return {};
  const Mat3 before = upright ? Mat3(Mat3::Identity()) : aimed_;
  const Vec3 z = axis / length, was = before.col(2);
  aimed_ =
      was.dot(z) > -1 + 1e-9 ? Mat3(rotation(shortest_turn(was, z)) * before) : frame_from_axis(z);
  return Pose{tip_mm, aimed_ * rotation(Vec3(0, 0, roll_rad))};
}

void SessionHand::aim(const Vec3& tip_mm, const Vec3& axis, double time_s, double pressure) {
  if (!pointer) return;
  const std::optional<Pose> pose = pose_of(tip_mm, axis, !pressed_);
  if (!pose) return;
  pressure_ = pressure;
  if (!pressed_)
    pointer->hover(*pose);
  else if (!std::isfinite(time_s))
    return;
  else if (guided_)
    guided_->move(*pose, time_s,
                  [&](const Pose& at, double s) { pointer->move(at, s, pressure_); });
  else
    pointer->move(*pose, time_s, pressure_);
}

std::optional<Pose> SessionHand::begin_at(const Vec3& tip_mm, const Vec3& axis, double time_s,
                                          const StrokeGuideSettings& guide) {
  if (!std::isfinite(time_s)) return {};
  std::optional<Pose> pose = pose_of(tip_mm, axis, true);
  if (!pose) return {};
  guided_.reset();
  if (guide.guides()) pose = guided_.emplace(guide).begin(*pose, time_s);
  return pose;
}

void SessionHand::press(const Pose& pose, double time_s, double pressure) {
  pressure_ = pressure;
  stroke_ = pointer->begin(pose, time_s, pressure_);
  pressed_ = true;
}

void SessionHand::lift() {
  pressed_ = false;
  if (guided_) guided_->end([&](const Pose& at, double s) { pointer->move(at, s, pressure_); });
  pointer->end();
}

void SessionHand::note(const HandTick& tick) {
  if (!held) return;
  held->safety = tick.safety;
  held->trip = tick.trip;
  held->given_n = std::sqrt(tick.given.force.squaredNorm());
}

void SessionHand::close() {
  pressed_ = false;
  pointer = nullptr;
}

}  // namespace kibori
