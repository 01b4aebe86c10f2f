// SPDX-License-Identifier: MIT
// Where the rings of a log are: the same for the eye (picture/wood.h, web/src/view/wood.ts) and for
// the tool (edit/grain.h). What is changed here is changed in web/src/view/wood.ts.
#pragma once

#include <kibori/geometry/vec.h>

namespace kibori {

// A log: where its pith runs, how wide its rings are.
struct Log {
  Vec3 pith = Vec3::Zero();    // a point on it [mm]
  Vec3 along = Vec3::UnitZ();  // unit, the way the tree grew
  double ring = 2;             // mean width of a year's ring [mm]
};

// The log that a plank of that box was cut from: the grain runs along its longest side; the pith
// lies below and beside it, but in a log, whose other two sides are equal, near the middle.
Log log_of(const Box& plank);

// A number in [0, 1) for a corner of the integer lattice.
double corner_value(int x, int y, int z);
// Smooth value noise in [-1, 1], one bump a unit.
double value_noise(const Vec3& p);

// By how many rings a point [mm] is off from where it were if the tree were round and straight:
// slow bends along the trunk, waves around it.
double ring_wave(const Log& log, const Vec3& point);

// How many rings a point is away from the pith: the whole part is the year.
inline double rings_at(const Log& log, const Vec3& point, double wave) {
  const Vec3 from = point - log.pith, across = from - from.dot(log.along) * log.along;
  return across.norm() / log.ring + wave;
}

// 0: early wood, light; 1: late wood, dark. Early wood grows dark slowly, and ends at once: with t
// from 0 to 1 over the year's rest after its early wood, it is t^2 (3 - 2 t), and falls to 0 over
// the last kRingEdge of the year.
double late_wood(double rings);
inline constexpr double kRingEdge = 0.06;
// The share of that year's ring that is early wood: 0.55 to 0.85.
double early_wood(double year);

}  // namespace kibori
