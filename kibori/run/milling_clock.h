// SPDX-License-Identifier: MIT
// Estimates the duration of a path on a machine with limited acceleration. Internal: not installed.
#pragma once

#include <kibori/geometry/vec.h>

namespace kibori {

// Estimates the durations of moves that follow each other. A move begins with the speed that the
// corner before it permits, and accelerates. It ends with the speed that the corner after it
// permits.
class MillingClock {
 public:
  explicit MillingClock(double acceleration_mm_s2) : acceleration_(acceleration_mm_s2) {}

  // Returns the duration of a straight move with this programmed speed [s]. `direction` is a unit
  // vector, or zero for a move of rotary axes. The deceleration at the end of a move counts for the
  // next move.
  double seconds(const Vec3& direction, double length_mm, double speed_mm_s) {
    if (!(length_mm > 0 && speed_mm_s > 0)) return 0;
    // In a corner, the machine keeps only the part of its speed along the new direction.
    const double corner = direction.dot(last_direction_);
    const double start = corner > 0 ? std::min(last_speed_, speed_mm_s) * corner : 0;
    const double gain = std::max(0.0, speed_mm_s - start);
    last_direction_ = direction;
    const double needed = (speed_mm_s * speed_mm_s - start * start) / (2 * acceleration_);
    if (needed <= length_mm) {
      last_speed_ = speed_mm_s;
      // Acceleration costs gain^2 / (2 a v). The deceleration at the end of the last move costs the
      // same, if both moves have the same speed.
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
