// SPDX-License-Identifier: MIT
// Simulates a hand that holds a device. Virtual devices and game controllers use it, and tests of
// stability.
//
//   target ──/\/\/\──┬── [hand + device mass] ── device's own damping
//            ──▭──   ┘            ▲ force from the program
//
// The hand follows a target through a spring and a damper (the grip). The device has its own mass
// and damping. Each tick integrates the motion in 20 steps. The steps are implicit in springs and
// dampers, so every grip is stable.
#pragma once

#include <algorithm>
#include <cmath>

#include <kibori/geometry/vec.h>

namespace kibori {

struct HandSettings {
  double hand_mass_kg = 0.1;
  double grip_n_mm = 0.5;  // stiffness of the spring between target and device
  double grip_damping_ns_mm = 0.005;
  double device_mass_kg = 0.1;
  double device_damping_ns_mm = 0.001;
};

class SimulatedHand {
 public:
  SimulatedHand(const HandSettings& settings, const Vec3& at_mm) : s_(settings), position_(at_mm) {}

  // Advances by dt_s under a constant force from the program. During this time, the target moves at
  // the given velocity. At the end, it is at target_mm.
  void step(const Vec3& force_n, const Vec3& target_mm, const Vec3& target_velocity_mm_s,
            double dt_s) {
    constexpr int kSteps = 20;
    const double dt = dt_s / kSteps;
    // N = kg m/s^2 = 1000 kg mm/s^2.
    const double mass = (s_.hand_mass_kg + s_.device_mass_kg) / 1000;
    for (int i = 1; i <= kSteps; i++) {
      const Vec3 target = target_mm + target_velocity_mm_s * (dt * (i - kSteps));
      // Implicit in the dampers and the spring:
      // v' = (m v + dt (F + k (x_t - x) + b v_t)) / (m + dt b + dt^2 k).
      const double damping = s_.grip_damping_ns_mm + s_.device_damping_ns_mm;
      const Vec3 push = force_n + s_.grip_n_mm * (target - position_) +
                        s_.grip_damping_ns_mm * target_velocity_mm_s;
      velocity_ = (mass * velocity_ + dt * push) / (mass + dt * damping + dt * dt * s_.grip_n_mm);
      position_ += dt * velocity_;
      const Vec3 grip = s_.grip_n_mm * (target - position_) +
                        s_.grip_damping_ns_mm * (target_velocity_mm_s - velocity_);
      work_mj_ += dt * grip.dot(velocity_);
      min_work_mj_ = std::min(min_work_mj_, work_mj_);
    }
  }

  const Vec3& position_mm() const { return position_; }
  const Vec3& velocity_mm_s() const { return velocity_; }
  // Return the work of the grip on the device so far, and the minimum of this work [mJ]. If it is
  // below 0, device and program together produced energy.
  double work_mj() const { return work_mj_; }
  double min_work_mj() const { return min_work_mj_; }

 private:
  HandSettings s_;
  Vec3 position_, velocity_ = Vec3::Zero();
  double work_mj_ = 0, min_work_mj_ = 0;
};

}  // namespace kibori
