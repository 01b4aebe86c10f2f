// SPDX-License-Identifier: MIT
// Merges poses of a path into one straight motion. Corners of the path stay.
//
//   ●──●───●──●──────●      one motion: all poses are within the tolerance, in the same order
//                     ╲
//                      ●    add() returns false: the motion must end at the pose before
//
// The pressure of a pen must also change evenly along the motion, within kPressureTolerance.
//
// A PoseMerger keeps all merged poses, because every new pose changes the motion. It does not
// allocate.
#pragma once

#include <array>
#include <cstddef>

#include <kibori/geometry/vec.h>

namespace kibori {

class PoseMerger {
 public:
  // Starts a motion at `from`. A turn counts as the path of a point with the distance `reach_mm`
  // from the tip. If reach_mm is 0, only the path of the tip counts.
  void begin(const Pose& from, double tolerance_mm, double reach_mm, double pressure = 1);
  // Makes `pose` the end of the motion. Returns false and changes nothing if a merged pose would be
  // outside the tolerance, or if kMaxPoses are merged.
  bool add(const Pose& pose, double pressure = 1);
  // Returns true if the motion has no end yet.
  bool empty() const { return count_ == 0; }
  // Return the end of the motion. Precondition: not empty().
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
