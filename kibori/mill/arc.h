// SPDX-License-Identifier: MIT
// Points, length and chords of an arc.
#pragma once

#include <kibori/geometry/vec.h>
#include <kibori/mill/canon_move.h>

namespace kibori {

// The path of an arc or a helix that starts at `from_mm`.
class ArcPath {
 public:
  ArcPath(const Vec3& from_mm, const ArcMove& arc);

  // Returns the point at a share of the path, 0..1. The first and the last point are exact.
  Vec3 at(double share) const;
  // Returns the angle of the whole path [rad]. It is positive if the path is counter-clockwise.
  double angle_rad() const { return sweep_; }
  double length_mm() const;
  double radius_mm() const;  // the larger of the radii at start and end
  // Returns the number of equal chords for which no chord is farther than `sagitta_mm` from the
  // arc.
  int chords(double sagitta_mm) const;

 private:
  Vec3 from_, to_, centre_;
  ArcAxes axes_;
  double start_radius_, end_radius_, start_angle_, sweep_;
};

}  // namespace kibori
