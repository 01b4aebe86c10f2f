// SPDX-License-Identifier: MIT
#include <kibori/haptics/safety.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace kibori {
namespace {

double length(const Vec3& v) { return std::sqrt(v.squaredNorm()); }

// Shortens v to at most `max`. The result is slightly below, so that rounding cannot exceed the
// limit.
Vec3 within(const Vec3& v, double max) {
  const double l = length(v);
  return l > max ? Vec3(v * (max * (1 - 1e-12) / l)) : v;
}

// Moves from `last` towards `wanted` by at most `step`. A change that only shortens the vector is
// not limited.
Vec3 towards(const Vec3& last, const Vec3& wanted, double step) {
  const Vec3 change = wanted - last;
  if (length(change) <= step) return wanted;
  const double l = length(last);
  const double smaller = std::min(l, length(wanted));
  const Vec3 from = l > 0 ? Vec3(last * (smaller / l)) : last;
  return from + within(wanted - from, step);
}

}  // namespace

std::string trip_text(Trip trip) {
  switch (trip) {
    case Trip::none:
      return "no trip";
    case Trip::command_stale:
      return "forces were switched off because none had been computed for 20 ms; arm again when "
             "the program is fast enough";
    case Trip::over_speed:
      return "forces were switched off because the device moved faster than its limit; hold it "
             "still and arm again";
    case Trip::device_failed:
      return "forces were switched off because the device reported an error";
    case Trip::device_unplugged:
      return "forces were switched off because the device was unplugged";
    case Trip::not_finite:
      return "forces were switched off because a computed force was not a number; please report "
             "this";
  }
  return {};
}

SafetyStage::SafetyStage(const DeviceCapabilities& limits, double tick_s)
    : force_n_(std::max(0.0, limits.force_n)),
      torque_nmm_(limits.dof_out > 3 ? std::max(0.0, limits.torque_nmm) : 0),
      force_step_n_(limits.force_rate_n_s * tick_s),
      torque_step_nmm_(limits.torque_rate_nmm_s * tick_s),
      speed_mm_s_(limits.speed_mm_s),
      tick_s_(tick_s) {}

void SafetyStage::arm() {
  trip_ = Trip::none;
  state_ = State::waiting;
  gain_ = 0;
  last_ = {};
}

void SafetyStage::disarm() {
  state_ = State::off;
  gain_ = 0;
  last_ = {};
}

Wrench SafetyStage::latch(Trip trip) {
  disarm();
  trip_ = trip;
  return {};
}

Wrench SafetyStage::pass(const SafetyInput& input) {
  if (state_ == State::off) return {};
  // The comparisons are negated, so that NaN also trips.
  if (input.device == DeviceStatus::unplugged) return latch(Trip::device_unplugged);
  if (input.device == DeviceStatus::failed) return latch(Trip::device_failed);
  if (!input.wanted.force.allFinite() || !input.wanted.moment.allFinite() ||
      !input.velocity_mm_s.allFinite() || !std::isfinite(input.command_age_s))
    return latch(Trip::not_finite);
  const double force = length(input.wanted.force), torque = length(input.wanted.moment);
  if (!std::isfinite(force) || !std::isfinite(torque)) return latch(Trip::not_finite);
  if (!(input.command_age_s <= kDeadS)) return latch(Trip::command_stale);
  if (!(length(input.velocity_mm_s) <= speed_mm_s_)) return latch(Trip::over_speed);

  if (state_ == State::waiting) {
    if (force > kArmShare * force_n_ || (torque_nmm_ > 0 && torque > kArmShare * torque_nmm_))
      return {};
    state_ = State::on;
  }
  if (input.command_age_s > kStaleS)
    gain_ = std::max(0.0, gain_ - tick_s_ / kFadeS);
  else
    gain_ = std::min(1.0, gain_ + tick_s_ / kRampUpS);
  const Vec3 wanted_force = within(input.wanted.force, force_n_) * gain_,
             wanted_moment = within(input.wanted.moment, torque_nmm_) * gain_;
  last_.force = within(towards(last_.force, wanted_force, force_step_n_), force_n_);
  last_.moment = within(towards(last_.moment, wanted_moment, torque_step_nmm_), torque_nmm_);
  return last_;
}

Status check_stability(const Rendering& r, const DeviceCapabilities& device) {
  const double half = 0.5 * r.tick_s, used = r.stiffness_n_mm * half + std::abs(r.viscosity_ns_mm);
  if (used <= device.damping_ns_mm) return Ok{};
  const double left = device.damping_ns_mm - std::abs(r.viscosity_ns_mm);
  char text[400];
  if (left > 0)
    std::snprintf(text, sizeof text,
                  "stiffness %.4g N/mm at %.4g Hz with viscosity %.4g N s/mm needs %.4g N s/mm of "
                  "damping and "
                  "%s brings %.4g; lower the stiffness to %.4g N/mm or raise the rate to %.4g Hz",
                  r.stiffness_n_mm, 1 / r.tick_s, r.viscosity_ns_mm, used, device.name.c_str(),
                  device.damping_ns_mm, std::floor(left / half * 1000) / 1000,
                  std::ceil(r.stiffness_n_mm / (2 * left)));
  else
    std::snprintf(
        text, sizeof text,
        "viscosity %.4g N s/mm alone is more than the %.4g N s/mm of damping that %s brings; lower "
        "the viscosity",
        r.viscosity_ns_mm, device.damping_ns_mm, device.name.c_str());
  return Error{text};
}

}  // namespace kibori
