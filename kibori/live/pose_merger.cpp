// SPDX-License-Identifier: MIT
#include <kibori/live/pose_merger.h>

#include <algorithm>
#include <cmath>

namespace kibori {

void PoseMerger::begin(const Pose& from, double tolerance_mm, double reach_mm, double pressure) {
  from_ = from;
  tolerance_mm_ = tolerance_mm;
  reach_mm_ = reach_mm;
  from_pressure_ = pressure;
  count_ = 0;
}

bool PoseMerger::add(const Pose& pose, double pressure) {
  const Pose& last = empty() ? from_ : end();
  if (!empty() && pose.tip == last.tip && pose.frame == last.frame && pressure == end_pressure())
    return true;
  if (count_ == kMaxPoses) return false;
  const Vec3 way = pose.tip - from_.tip;
  const bool turns = reach_mm_ > 0;
  const Vec3 turn = turns ? rotation_between(from_.frame, pose.frame) : Vec3(Vec3::Zero());
  const double distance2 = way.squaredNorm(), turn2 = turn.squaredNorm();
  // The place on the motion, 0 to 1, must never decrease: a path that goes back and forth cannot be
  // merged.
  double share = 0;
  for (size_t i = 0; i < count_; i++) {
    const Vec3 at = poses_[i].tip - from_.tip;
    if (distance2 > 0)
      share = std::clamp(at.dot(way) / distance2, share, 1.0);
    else if (turn2 > 0)
      share =
          std::clamp(rotation_between(from_.frame, poses_[i].frame).dot(turn) / turn2, share, 1.0);
    double off = std::sqrt((at - share * way).squaredNorm());
    if (turns) {
      const Mat3 there = rotation(Vec3(share * turn)) * from_.frame;
      off += reach_mm_ * std::sqrt(rotation_between(there, poses_[i].frame).squaredNorm());
    }
    if (!(off <= tolerance_mm_)) return false;
    const double even = from_pressure_ + share * (pressure - from_pressure_);
    if (!(std::fabs(pressures_[i] - even) <= kPressureTolerance)) return false;
  }
  pressures_[count_] = pressure;
  poses_[count_++] = pose;
  return true;
}

}  // namespace kibori
