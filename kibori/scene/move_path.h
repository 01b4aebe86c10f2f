// SPDX-License-Identifier: MIT
// Computes the path of a scene's move. Only moves that are not straight, and moves whose tool leads
// or stamps, have one.
#pragma once

#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>

namespace kibori {

struct Move;

// The tool's poses along a move. The tool moves straight from each one to the next.
struct MovePath {
  std::vector<Pose> places;
  std::vector<double> at_mm;  // length of the path from the start of the move to each pose
  bool leads = false;         // true: the tool turns with the path; false: it keeps its frame

  double length_mm() const { return at_mm.back(); }
  // Pose after a share (0 to 1) of the path's length. The move begins at `start`.
  Pose at(double share, const Pose& start) const;
};

// The path from the end of `from`. Errors: points that do not define a curve; an arc that starts on
// its axis or has too many chords; those of check_stroke_guide.
Result<MovePath> path_of(const Move& from, const Move& to, double pitch_mm);

}  // namespace kibori
