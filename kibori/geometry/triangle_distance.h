// SPDX-License-Identifier: MIT
// The distance from a point to a triangle.
#pragma once

#include <algorithm>
#include <cmath>

#include <kibori/geometry/vec.h>

namespace kibori {

// Returns the distance from p to the triangle with corners a, b and c, in the unit of the
// arguments. Source: Ericson, Real-Time Collision Detection, 5.1.5.
inline double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, n = ab.cross(ac);
  if (!(n.squaredNorm() > 1e-20 * ab.squaredNorm() * ac.squaredNorm())) {
    // Within rounding, the corners are on one line: use the nearest side.
    const auto side = [&](const Vec3& from, const Vec3& along) {
      const double length2 = along.squaredNorm();
      const double t = length2 > 0 ? std::clamp((p - from).dot(along) / length2, 0.0, 1.0) : 0;
      return (p - from - t * along).norm();
    };
    return std::min({side(a, ab), side(a, ac), side(b, c - b)});
  }
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.norm();
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.norm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).norm();
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.norm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).norm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return (bp - (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b)).norm();
  return std::abs(n.dot(ap)) / n.norm();
}

}  // namespace kibori
