// SPDX-License-Identifier: MIT
// The way of a scene's move that is not straight, or whose tool leads itself.
#pragma once

#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>

namespace kibori {

struct Move;

// Where a move takes the tool, place by place.
struct MoveWay {
  std::vector<Pose> places;
  std::vector<double> at_mm;  // of each place: how far it is from where the move begins
  bool leads = false;         // else the tool keeps the frame it has

  double length_mm() const { return at_mm.back(); }
  // Of a move that begins at `start`; share: 0 to 1.
  Pose at(double share, const Pose& start) const;
};

// Errors: points that are no curve.
Result<MoveWay> way_of(const Move& from, const Move& to, double pitch_mm);

}  // namespace kibori
