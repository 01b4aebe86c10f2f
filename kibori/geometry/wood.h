// SPDX-License-Identifier: MIT
// Positions of the rings of a log. The pictures (picture/wood.h, web/src/view/wood.ts) and the
// cutting forces (edit/grain.h) use the same rings. Change web/src/view/wood.ts together with this
// file.
#pragma once

#include <kibori/base/field_info.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// A log: the position of its pith and the width of its rings.
struct Log {
  Vec3 pith = Vec3::Zero();    // a point on it [mm]
  Vec3 along = Vec3::UnitZ();  // unit, the direction in which the tree grew
  double ring = 2;             // mean width of a year's ring [mm]
};

// How a stock was cut from its log, in the stock's frame. A field that is 0 follows from the
// stock's shape.
struct LogCut {
  double ring_mm = 0;        // mean width of a ring
  Vec3 axis = Vec3::Zero();  // direction of the fibres, any length
  Vec3 pith = Vec3::Zero();  // a point of the pith [mm]; used if there is an axis

  static void for_fields(auto&& f) {
    f(FieldInfo{"ring_mm", "ring_width", FieldRange::not_negative, Stored::unless_default},
      &LogCut::ring_mm);
    f(FieldInfo{"axis", "axis", {}, Stored::unless_default}, &LogCut::axis);
    f(FieldInfo{"pith", "pith", {}, Stored::unless_default}, &LogCut::pith);
  }
  bool operator==(const LogCut&) const = default;
};

// The log from which a plank with that box was cut. Values that `cut` does not give follow from the
// box, as in documents before version 0.3. The fibres are nearly parallel to the longest side of
// the box. The width of a ring is this side / 26. If the other two sides are equal, the plank is a
// log, and the pith is near its middle. Otherwise, the pith is outside the plank.
Log log_of(const Box& plank, const LogCut& cut = {});

// Pseudo-random number in [0, 1) for a corner of the integer lattice.
double corner_value(int x, int y, int z);
// Smooth value noise in [-1, 1], one bump per unit.
double value_noise(const Vec3& p);

// A real tree is neither round nor straight: it has slow bends along the trunk, and waves around
// it. Returns their effect at a point [mm]: the displacement of the rings, in rings.
double ring_wave(const Log& log, const Vec3& point);

// Number of rings between a point and the pith. The whole part is the year. `wave` is ring_wave at
// the point.
inline double rings_at(const Log& log, const Vec3& point, double wave) {
  const Vec3 from = point - log.pith, across = from - from.dot(log.along) * log.along;
  return across.norm() / log.ring + wave;
}

// 0: light early wood. 1: dark late wood. In a year's ring, the wood becomes dark slowly and light
// again suddenly. Let t go from 0 to 1 from the end of the early wood to the end of the year. The
// value is t^2 (3 - 2 t). Over the last kRingEdge of the year, it falls to 0.
double late_wood(double rings);
inline constexpr double kRingEdge = 0.06;
// Share of early wood in that year's ring: 0.55 to 0.85.
double early_wood(double year);

}  // namespace kibori
