// SPDX-License-Identifier: MIT
// Arcs as points: the path of an ArcMove, and its chords.
#pragma once

#include <kibori/geometry/vec.h>
#include <kibori/mill/canon_move.h>

namespace kibori {

// The path of an arc or a helix from a known start.
class ArcPath {
 public:
  ArcPath(const Vec3& from_mm, const ArcMove& arc);

  // Point at a share of the path, 0..1. The ends are exact.
  Vec3 at(double share) const;
  // Angle of the whole path [rad], positive if counter-clockwise.
  double angle_rad() const { return sweep_; }
  double length_mm() const;
  double radius_mm() const;  // the larger of those at start and end
  // Number of equal chords so that no chord is farther than `sagitta_mm` from the arc.
  int chords(double sagitta_mm) const;

 private:
  Vec3 from_, to_, centre_;
  ArcAxes axes_;
  double start_radius_, end_radius_, start_angle_, sweep_;
};

}  // namespace kibori
