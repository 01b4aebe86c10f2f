// SPDX-License-Identifier: MIT
#include <kibori/devices/pointer_device.h>

#include <algorithm>
#include <cmath>

namespace kibori {
namespace {

// It is this long behind, which hides the steps between two events of a screen.
constexpr double kBehindS = 0.012;
constexpr double kFastest = 800;    // mm/s
constexpr double kFastestTurn = 8;  // rad/s: the surface's normal turns at once at an edge, a hand does not

}  // namespace

PointerDevice::PointerDevice(double rate_hz) : tick_s_(1 / rate_hz) {
  capabilities_.name = "a pointer";
  capabilities_.dof_in = 6;
  capabilities_.dof_out = 0;
  // No force reaches a hand, so that none has to be limited but for what is shown.
  capabilities_.force_n = 1000;
  capabilities_.torque_nmm = 1e5;
  capabilities_.force_rate_n_s = 1e7;
  capabilities_.torque_rate_nmm_s = 1e9;
  capabilities_.damping_ns_mm = 1000;
  capabilities_.speed_mm_s = 2 * kFastest;
  capabilities_.stiffness_n_mm = 0.5;
}

void PointerDevice::aim(const Vec3& position_mm, const Mat3& frame, bool at_once) {
  last_.position_mm = position_mm;
  last_.frame = frame;
  if (at_once) {
    last_.jump_mm = position_mm;
    last_.jump_frame = frame;
    last_.jumps++;
  }
  aimed_.put(last_);
}

DeviceStatus PointerDevice::read(DeviceReading& reading) {
  there_ |= aimed_.take(target_);
  if (!there_) return DeviceStatus::stale;
  if (jumped_ != target_.jumps) {
    jumped_ = target_.jumps;
    now_.position_mm = target_.jump_mm;
    now_.frame = target_.jump_frame;
    reading = now_;
    return DeviceStatus::ok;
  }
  const double share = 1 - std::exp(-tick_s_ / kBehindS);
  Vec3 step = share * (target_.position_mm - now_.position_mm);
  const double length = std::sqrt(step.squaredNorm()), most = kFastest * tick_s_;
  if (length > most) step *= most / length;
  now_.position_mm += step;
  const Vec3 turn = rotation_between(now_.frame, target_.frame);
  const double angle = std::sqrt(turn.squaredNorm());
  if (angle > 1e-6)
    now_.frame = (rotation(Vec3(std::min(share, kFastestTurn * tick_s_ / angle) * turn)) * now_.frame).eval();
  else
    now_.frame = target_.frame;
  reading = now_;
  return DeviceStatus::ok;
}

}  // namespace kibori
