// SPDX-License-Identifier: MIT
// Where a parametric stroke takes each point of the material: a function of the brush where the
// stroke began and of how far the hand has come since.
//
//   grab    x + w d                       d: the hand's way
//   grab, keep volume                     a flow without sources: v = w((1 - 4 r^2) d + 3 (d.x) x)
//   nudge   as grab, d along the surface
//   twist   a turn by w t                 about the tool's axis; t: its change of roll
//   bend    a turn by w |d| / R           about axis x d, so that what stands on the axis leans to
//   d pinch   c + (1 - w q / (1 + q)) y     q = |d| / R, y = x - c scale   c + (1 + w (g - 1)) y, n
//   times   g^n = 1 + (d . axis) / R, g at most 1.5
//
// with the falloff w of brush.h about the centre c, r the distance from it in radii, and the amount
// times the brush's strength. A grab is made of steps of half a radius, whose
// centres go with the hand, so that no point passes another.
#pragma once

#include <kibori/geometry/vec.h>
#include <kibori/reshape/brush.h>

namespace kibori {

enum class WarpVerb { grab, nudge, twist, bend, pinch, scale, node };

// A hand that drags: lengths in the units of the points that are mapped.
struct Drag {
  Vec3 centre = Vec3::Zero();   // where the stroke began
  Vec3 axis = Vec3::UnitZ();    // of the tool there, unit
  Vec3 normal = Vec3::UnitZ();  // of the surface there, unit, out of the material
  Vec3 way = Vec3::Zero();      // of the tip, since
  double turn_rad = 0;          // of the tool about its axis, since
};

class WarpMap {
 public:
  // `radius`: of the brush, in the drag's units. A node is no map: it leaves all points where they
  // are.
  WarpMap(WarpVerb verb, const Brush& brush, double radius, const Drag& drag);

  Vec3 operator()(const Vec3& point) const;
  // No point outside moves, and none leaves it.
  const Box& reach() const { return reach_; }
  // Whether no point moves.
  bool idle() const { return idle_; }
  // Of a grab that keeps volume: before it, the surface goes out by so much at the centre.
  void lift(double amount) { lift_ = amount * normal_; }

 private:
  double weight(const Vec3& from_centre) const {
    return falloff_weight(falloff_, from_centre.norm() / radius_);
  }
  Vec3 flow(const Vec3& point) const;

  WarpVerb verb_;
  Falloff falloff_;
  double radius_;
  Vec3 centre_;
  bool keep_volume_ = false, idle_ = true;
  Vec3 step_ = Vec3::Zero(), rest_ = Vec3::Zero();  // of a grab: full steps, and the last one
  int steps_ = 0;                                   // full ones; of scale: all
  Vec3 way_ = Vec3::Zero(), normal_, lift_ = Vec3::Zero();
  Vec3 turn_axis_ = Vec3::UnitZ();
  double amount_ = 0;  // of a turn [rad], a pinch or a step of scale
  Box reach_;
};

}  // namespace kibori
