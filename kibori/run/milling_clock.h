// SPDX-License-Identifier: MIT
// Time of a path on a machine with limited acceleration. Internal: not installed.
#pragma once

#include <kibori/geometry/vec.h>

namespace kibori {

// Estimates the time of moves one after another. A move begins with the speed that the corner
// allows, accelerates, and ends with the speed that the next corner allows.
class MillingClock {
 public:
  explicit MillingClock(double acceleration_mm_s2) : acceleration_(acceleration_mm_s2) {}

  // Time of a straight move with this speed. `direction`: unit; zero for a move of rotary axes.
  double seconds(const Vec3& direction, double length_mm, double speed_mm_s) {
    if (!(length_mm > 0 && speed_mm_s > 0)) return 0;
    // The speed along both directions can stay.
    const double corner = direction.dot(last_direction_);
    const double start = corner > 0 ? std::min(last_speed_, speed_mm_s) * corner : 0;
    const double gain = std::max(0.0, speed_mm_s - start);
    last_direction_ = direction;
    const double needed = (speed_mm_s * speed_mm_s - start * start) / (2 * acceleration_);
    if (needed <= length_mm) {
      last_speed_ = speed_mm_s;
      // If both moves have one speed, the loss at the end of the last one equals the gain here.
      return length_mm / speed_mm_s + gain * gain / (acceleration_ * speed_mm_s);
    }
    last_speed_ = std::sqrt(start * start + 2 * acceleration_ * length_mm);
    return 2 * length_mm / (start + last_speed_);
  }
  void stop() { last_speed_ = 0; }

 private:
  double acceleration_;
  Vec3 last_direction_ = Vec3::Zero();
  double last_speed_ = 0;
};

}  // namespace kibori
