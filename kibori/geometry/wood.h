// SPDX-License-Identifier: MIT
// Positions of the rings in a log. The pictures (picture/wood.h, web/src/view/wood.ts) and the
// cutting forces (edit/grain.h) use the same rings. If you change this file, change
// web/src/view/wood.ts, too.
#pragma once

#include <kibori/base/field_info.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// A log. Its pith is the line in the middle of the rings.
struct Log {
  Vec3 pith = Vec3::Zero();    // a point on the pith [mm]
  Vec3 along = Vec3::UnitZ();  // unit, the direction in which the tree grew
  double ring = 2;             // mean width of a year's ring [mm]
};

// How a stock was cut from its log, in the stock's frame. A field that is 0 is not given: log_of
// computes it from the stock's shape.
struct LogCut {
  double ring_mm = 0;        // mean width of a ring
  Vec3 axis = Vec3::Zero();  // direction of the fibres, any length
  Vec3 pith = Vec3::Zero();  // a point on the pith [mm]; used only if there is an axis

  static void for_fields(auto&& f) {
    f(FieldInfo{"ring_mm", "ring_width", FieldRange::not_negative, Stored::unless_default},
      &LogCut::ring_mm);
    f(FieldInfo{"axis", "axis", {}, Stored::unless_default}, &LogCut::axis);
    f(FieldInfo{"pith", "pith", {}, Stored::unless_default}, &LogCut::pith);
  }
  bool operator==(const LogCut&) const = default;
};

// Returns the log from which a plank with this box was cut. Values that `cut` does not give are
// computed from the box. (Documents before version 0.3 give no values.) The fibres are then nearly
// parallel to the longest side. The ring width is 1/26 of this side. If the other two sides are
// equal, the plank is a whole log: the pith is near its middle. Otherwise the pith is outside.
Log log_of(const Box& plank, const LogCut& cut = {});

// Returns a pseudo-random number in [0, 1) for a point with integer coordinates.
double corner_value(int x, int y, int z);
// Returns smooth noise in [-1, 1], interpolated between random values at integer coordinates.
double value_noise(const Vec3& p);

// The rings of a real tree are neither round nor straight: they bend slowly along the trunk, and
// have waves around it. Returns the displacement of the rings at a point, in rings. `point` is in
// mm.
double ring_wave(const Log& log, const Vec3& point);

// Returns the number of rings between the pith and a point. The whole part is the year. `wave` is
// ring_wave at the point.
inline double rings_at(const Log& log, const Vec3& point, double wave) {
  const Vec3 from = point - log.pith, across = from - from.dot(log.along) * log.along;
  return across.norm() / log.ring + wave;
}

// Returns how dark the wood is: 0 for light early wood, 1 for dark late wood. `rings` is rings_at.
// In a year's ring, the wood becomes dark slowly and light again suddenly. From the end of the
// early wood to the end of the year, t grows from 0 to 1. The value is t^2 (3 - 2 t), times a
// factor. This factor is 1, and falls to 0 over the last kRingEdge of the year.
double late_wood(double rings);
inline constexpr double kRingEdge = 0.06;
// Returns the share of early wood in the ring of this year: 0.55 to 0.85.
double early_wood(double year);

}  // namespace kibori
