// SPDX-License-Identifier: MIT
// Computes the path of a scene's move. Straight moves have no path, unless their tool leads or
// stamps.
#pragma once

#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>

namespace kibori {

struct Move;

// The poses of the tool during a move. Between two poses, the tool moves straight.
struct MovePath {
  std::vector<Pose> places;
  std::vector<double> at_mm;  // length of the path up to each pose
  bool leads = false;         // true if the tool turns with the path; false if it keeps its frame

  double length_mm() const { return at_mm.back(); }
  // Returns the pose after a share (0 to 1) of the path's length. `start` is the tool's pose before
  // the move.
  Pose at(double share, const Pose& start) const;
};

// Returns the path of the move `to`, from the end of the move `from`. Errors: the points do not
// define a curve; an arc starts on its axis or has too many chords; those of check_stroke_guide.
Result<MovePath> path_of(const Move& from, const Move& to, double pitch_mm);

}  // namespace kibori
