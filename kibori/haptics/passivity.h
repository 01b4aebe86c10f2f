// SPDX-License-Identifier: MIT
// Watches the energy that passes between hand and program, and can put a capped damping against
// what the program makes of its own (Hannaford and Ryu 2002).
#pragma once

#include <algorithm>
#include <cmath>

#include <kibori/haptics/force.h>

namespace kibori {

class PassivityObserver {
 public:
  // cap_ns_mm: the most damping the controller may add; 0: it only watches. It is part of the
  // viscosity that check_stability counts.
  explicit PassivityObserver(double cap_ns_mm = 0) : cap_ns_mm_(cap_ns_mm) {}

  // The device moved to `position` under the force of the tick before; `wanted` comes out with the
  // controller's damping added. `given` must then be told what really went out.
  Vec3 tick(const Vec3& position_mm, const Vec3& wanted_n, double tick_s) {
    const Vec3 moved = started_ ? Vec3(position_mm - last_position_) : Vec3(Vec3::Zero());
    energy_mj_ -= given_.dot(moved);
    min_mj_ = std::min(min_mj_, energy_mj_);
    last_position_ = position_mm;
    started_ = true;
    const double moved2 = moved.squaredNorm();
    if (!(cap_ns_mm_ > 0) || !(energy_mj_ < 0) || !(moved2 > 0)) return wanted_n;
    // Over a tick like this one, damping a takes a |moved|^2 / T.
    const double damping = std::min(cap_ns_mm_, -energy_mj_ * tick_s / moved2);
    return wanted_n - (damping / tick_s) * moved;
  }
  void given(const Vec3& force_n) { given_ = force_n; }

  // What the hand has put in less what it got back [N mm = mJ]: below 0 the program made energy.
  double energy_mj() const { return energy_mj_; }
  double min_mj() const { return min_mj_; }

 private:
  const double cap_ns_mm_;
  double energy_mj_ = 0, min_mj_ = 0;
  Vec3 given_ = Vec3::Zero(), last_position_ = Vec3::Zero();
  bool started_ = false;
};

}  // namespace kibori
