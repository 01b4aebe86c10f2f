// SPDX-License-Identifier: MIT
// The path of a scene's move that is not straight, or whose tool leads or stamps.
#pragma once

#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>

namespace kibori {

struct Move;

// The path of a move, pose by pose.
struct MovePath {
  std::vector<Pose> places;
  std::vector<double> at_mm;  // distance of each pose from the start of the move
  bool leads = false;         // false: the tool keeps its frame

  double length_mm() const { return at_mm.back(); }
  // Pose at a share (0 to 1) of the path of a move that begins at `start`.
  Pose at(double share, const Pose& start) const;
};

// Errors: points that do not define a curve.
Result<MovePath> path_of(const Move& from, const Move& to, double pitch_mm);

}  // namespace kibori
