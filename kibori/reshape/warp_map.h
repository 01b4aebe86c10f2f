// SPDX-License-Identifier: MIT
// Maps the points of the material in a parametric stroke. The map depends on the brush at the start
// of the stroke, and on the hand's displacement d since then.
//
//   grab    x + w d                       d: the hand's displacement
//   grab_connected                        as grab, for material connected with c (warp.h)
//   grab, keep volume                     a divergence-free flow:
//                                         v = w((1 - 4 r^2) d + 3 (d.x) x)
//   nudge   as grab, d along the surface
//   twist   a turn by w t                 about the tool's axis; t: its change of roll
//   bend    a turn by w |d| / R           about axis x d: the axis leans towards d
//   hook    as grab_connected, with w(r^2): a wide middle moves as a whole, and strands stay thick
//   pinch   c + (1 - w q / (1 + q)) y     q = |d| / R, y = x - c; a negative strength spreads
//   scale   c + (1 + w (g - 1)) y,        g^n = 1 + (d . axis) / R, g at most 1.5
//           n times
//
// Here w is the falloff of brush.h around the centre c, and r the distance from c in radii. The
// brush's strength multiplies the displacement or the angle. A grab consists of steps of half a
// radius (0.3 radii for hook, 0.1 if the volume is kept). The ball of influence moves with each
// step. Therefore, no point passes another one.
#pragma once

#include <kibori/geometry/vec.h>
#include <kibori/reshape/brush.h>

namespace kibori {

enum class WarpVerb { grab, nudge, twist, bend, pinch, scale, node, hook, grab_connected };

// The displacement of a hand since the start of the stroke. Lengths are in the units of the points
// that are mapped.
struct Drag {
  Vec3 centre = Vec3::Zero();        // position of the tip at the start of the stroke
  Vec3 axis = Vec3::UnitZ();         // unit vector along the tool's axis at the start
  Vec3 normal = Vec3::UnitZ();       // unit normal of the surface at `centre`, out of the material
  Vec3 displacement = Vec3::Zero();  // displacement of the tip since the start
  double turn_rad = 0;               // turn of the tool about its axis since the start
};

// The points that a grab can move: all balls of `radius` around the points from `from` to `to`
// [lattice units].
struct GrabReach {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  double radius = 0;

  bool holds(const Vec3& point) const;
};

class WarpMap {
 public:
  // `radius` is the brush's radius in the units of `drag`. The map of the verb `node` moves no
  // point.
  WarpMap(WarpVerb verb, const Brush& brush, double radius, const Drag& drag);

  Vec3 operator()(const Vec3& point) const;
  // Returns the box of influence. The map moves no point outside the box, and no point out of the
  // box.
  const Box& reach() const { return reach_; }
  // Returns true if the map moves no point.
  bool idle() const { return idle_; }
  // Only for a grab that keeps the volume: before the grab, the map moves the surface outwards by
  // `amount` at the centre.
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
  Vec3 step_ = Vec3::Zero(), rest_ = Vec3::Zero();  // full step and last step of a grab
  int steps_ = 0;  // number of full steps (for scale: of all steps)
  Vec3 displacement_ = Vec3::Zero(), normal_, lift_ = Vec3::Zero();
  Vec3 turn_axis_ = Vec3::UnitZ();
  double amount_ = 0;  // twist, bend: angle [rad]; pinch: share; scale: factor of one step
  Box reach_;
};

}  // namespace kibori
