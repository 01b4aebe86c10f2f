// SPDX-License-Identifier: MIT
// Merges poses of a path into one straight motion. Corners of the path are kept.
//
//   ●──●───●──●──────●      one motion: every pose is within the tolerance, in the same order
//                     ╲
//                      ●    add() returns false: the motion must end at the corner before
//
// The pressure of a pen must change evenly along the motion, too, within kPressureTolerance.
//
// It keeps the merged poses, because every new pose changes the motion. It allocates nothing.
#pragma once

#include <array>
#include <cstddef>

#include <kibori/geometry/vec.h>

namespace kibori {

class PoseMerger {
 public:
  // Starts a motion at `from`. A turn counts as the path of a point `reach_mm` from the tip. With a
  // reach of 0 only the tip's path counts.
  void begin(const Pose& from, double tolerance_mm, double reach_mm, double pressure = 1);
  // Makes `pose` the motion's end. Returns false and changes nothing if the motion would leave the
  // tolerance, or if kMaxPoses are merged.
  bool add(const Pose& pose, double pressure = 1);
  // True if the motion has no end yet.
  bool empty() const { return count_ == 0; }
  // The motion's end. There must be one.
  const Pose& end() const { return poses_[count_ - 1]; }
  double end_pressure() const { return pressures_[count_ - 1]; }

  static constexpr size_t kMaxPoses = 32;
  static constexpr double kPressureTolerance = 0.02;

 private:
  Pose from_;
  double tolerance_mm_ = 0, reach_mm_ = 0, from_pressure_ = 1;
  std::array<Pose, kMaxPoses> poses_{};
  std::array<double, kMaxPoses> pressures_{};
  size_t count_ = 0;
};

}  // namespace kibori
