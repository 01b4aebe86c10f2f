// SPDX-License-Identifier: MIT
// The map of a parametric stroke on points of the material. It is a function of the brush at the
// start of the stroke, and of the hand's displacement since then.
//
//   grab    x + w d                       d: the hand's displacement
//   grab_connected                        as grab, for material connected with c (warp.h)
//   grab, keep volume                     a divergence-free flow:
//                                         v = w((1 - 4 r^2) d + 3 (d.x) x)
//   nudge   as grab, d along the surface
//   twist   a turn by w t                 about the tool's axis; t: its change of roll
//   bend    a turn by w |d| / R           about axis x d: the axis leans towards d
//   hook    as grab_connected, with w(r^2): a wide middle moves as a whole, so a strand stays thick
//   pinch   c + (1 - w q / (1 + q)) y     q = |d| / R, y = x - c; a negative strength spreads
//   scale   c + (1 + w (g - 1)) y,        g^n = 1 + (d . axis) / R, g at most 1.5
//           n times
//
// Here w is the falloff of brush.h about the centre c, and r the distance from it in radii. The
// amount is multiplied by the brush's strength. A grab consists of steps of half a radius. Their
// centres move with the hand, so that no point passes another.
#pragma once

#include <kibori/geometry/vec.h>
#include <kibori/reshape/brush.h>

namespace kibori {

enum class WarpVerb { grab, nudge, twist, bend, pinch, scale, node, hook, grab_connected };

// The drag of a hand. Lengths are in the units of the mapped points.
struct Drag {
  Vec3 centre = Vec3::Zero();        // at the start of the stroke
  Vec3 axis = Vec3::UnitZ();         // of the tool there, unit
  Vec3 normal = Vec3::UnitZ();       // of the surface there, unit, out of the material
  Vec3 displacement = Vec3::Zero();  // displacement of the tip since then
  double turn_rad = 0;               // of the tool about its axis, since then
};

// A grab reaches the balls of `radius` about all points from `from` to `to` [lattice units].
struct GrabReach {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  double radius = 0;

  bool holds(const Vec3& point) const;
};

class WarpMap {
 public:
  // `radius`: of the brush, in the drag's units. The verb `node` is no map: it moves no point.
  WarpMap(WarpVerb verb, const Brush& brush, double radius, const Drag& drag);

  Vec3 operator()(const Vec3& point) const;
  // No point outside this box moves, and no point inside leaves it.
  const Box& reach() const { return reach_; }
  // True if no point moves.
  bool idle() const { return idle_; }
  // For a grab that keeps volume: moves the surface outwards by this amount at the centre, before
  // the grab.
  void lift(double amount) { lift_ = amount * normal_; }

 private:
  double weight(const Vec3& from_centre) const {
    const double r = from_centre.norm() / radius_;
    return falloff_weight(falloff_, verb_ == WarpVerb::hook ? r * r : r);
  }
  Vec3 flow(const Vec3& point) const;

  WarpVerb verb_;
  Falloff falloff_;
  double radius_;
  Vec3 centre_;
  bool keep_volume_ = false, idle_ = true;
  Vec3 step_ = Vec3::Zero(), rest_ = Vec3::Zero();  // of a grab: full steps, and the last one
  int steps_ = 0;                                   // number of full steps; for scale: of all steps
  Vec3 displacement_ = Vec3::Zero(), normal_, lift_ = Vec3::Zero();
  Vec3 turn_axis_ = Vec3::UnitZ();
  double amount_ = 0;  // of a turn [rad], a pinch or a step of scale
  Box reach_;
};

}  // namespace kibori
