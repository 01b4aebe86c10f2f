// SPDX-License-Identifier: MIT
// Counts the energy that the hand and the program exchange. The observer can also add damping, up
// to a limit, to remove energy that the program generates (Hannaford and Ryu 2002).
#pragma once

#include <algorithm>
#include <cmath>

#include <kibori/haptics/force.h>

namespace kibori {

class PassivityObserver {
 public:
  // cap_ns_mm: maximum damping that the observer adds; 0: it only counts. check_stability needs
  // this maximum as a part of Rendering::viscosity_ns_mm.
  explicit PassivityObserver(double cap_ns_mm = 0) : cap_ns_mm_(cap_ns_mm) {}

  // Call this after the device moved to `position_mm` under the force of the last tick. Returns
  // `wanted_n` plus the force of the damping. Then call given() with the force that the device
  // outputs.
  Vec3 tick(const Vec3& position_mm, const Vec3& wanted_n, double tick_s) {
    const Vec3 moved = started_ ? Vec3(position_mm - last_position_) : Vec3(Vec3::Zero());
    energy_mj_ -= given_.dot(moved);
    min_mj_ = std::min(min_mj_, energy_mj_);
    last_position_ = position_mm;
    started_ = true;
    const double moved2 = moved.squaredNorm();
    if (!(cap_ns_mm_ > 0) || !(energy_mj_ < 0) || !(moved2 > 0)) return wanted_n;
    // In a tick with this displacement, damping b dissipates b |moved|^2 / T.
    const double damping = std::min(cap_ns_mm_, -energy_mj_ * tick_s / moved2);
    return wanted_n - (damping / tick_s) * moved;
  }
  void given(const Vec3& force_n) { given_ = force_n; }

  // Returns the energy that the hand put in, minus the energy that it got back [N mm = mJ]. If the
  // result is below 0, the program generated energy.
  double energy_mj() const { return energy_mj_; }
  double min_mj() const { return min_mj_; }

 private:
  const double cap_ns_mm_;
  double energy_mj_ = 0, min_mj_ = 0;
  Vec3 given_ = Vec3::Zero(), last_position_ = Vec3::Zero();
  bool started_ = false;
};

}  // namespace kibori
