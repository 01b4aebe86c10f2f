// SPDX-License-Identifier: MIT
// Exact crossings of a field's rays with a triangle. The (u, v) of the vertices are rounded to an
// integer grid that is finer than a cell. Then integer edge functions decide whether a ray passes
// through the triangle.
//
// If a ray meets an edge or a vertex exactly, the code treats the ray as shifted by an infinitely
// small (eps_u, eps_v). The shift along x is far larger than the shift along y. The shift along y
// is far larger than the shift along z. Therefore, exactly one of the triangles at an edge owns the
// ray, and all three fields agree on the owner. A ray enters a closed surface as often as it leaves
// the surface.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <kibori/base/tolerances.h>
#include <kibori/geometry/axis.h>
#include <kibori/geometry/lattice.h>

namespace kibori {

// Rays with u0 <= u < u1, v0 <= v < v1.
struct RayRect {
  int u0, u1, v0, v1;
};

// A vertex in one field's coordinates: (u, v) in steps of the grid, exact depth [lattice units].
struct SnappedPoint {
  int64_t u, v;
  double depth;
};

// Rounds a vertex to the grid of one field.
inline SnappedPoint snap(const LatticePoint& point, Axis axis) {
  constexpr double kScale = 1 << kSnapBits;
  return {std::llround(point[u_index(axis)] * kScale), std::llround(point[v_index(axis)] * kScale),
          point[depth_index(axis)]};
}

// Calls f(u, v, depth, sign) for each ray of `rect` that crosses triangle abc. The sign is +1 if
// the ray enters the solid (it runs against the outward normal), and -1 if the ray leaves the
// solid.
template <class F>
void for_crossings(const SnappedPoint& a, const SnappedPoint& b, const SnappedPoint& c, Axis axis,
                   const RayRect& rect, F&& f) {
  constexpr int64_t kOne = int64_t{1} << kSnapBits, kHalf = kOne / 2;
  const int64_t area = (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
  if (area == 0) return;
  const auto [u_min, u_max] = std::minmax({a.u, b.u, c.u});
  const auto [v_min, v_max] = std::minmax({a.v, b.v, c.v});
  // Ray i is at (i + 1/2) kOne.
  const auto first_at = [](int64_t x) { return static_cast<int>((x + kHalf - 1) >> kSnapBits); };
  const auto last_at = [](int64_t x) { return static_cast<int>((x - kHalf) >> kSnapBits); };
  const int u0 = std::max(rect.u0, first_at(u_min)), u1 = std::min(rect.u1 - 1, last_at(u_max));
  const int v0 = std::max(rect.v0, first_at(v_min)), v1 = std::min(rect.v1 - 1, last_at(v_max));
  if (u0 > u1 || v0 > v1) return;

  const int64_t turn = area > 0 ? 1 : -1;
  const SnappedPoint* p[3] = {&a, &b, &c};
  int64_t du[3], dv[3], start[3];
  for (int e = 0; e < 3; e++) {
    const SnappedPoint &from = *p[e], &to = *p[(e + 1) % 3];
    du[e] = turn * (to.u - from.u);
    dv[e] = turn * (to.v - from.v);
    const int64_t pu = (int64_t{u0} << kSnapBits) + kHalf, pv = (int64_t{v0} << kSnapBits) + kHalf;
    start[e] = du[e] * (pv - from.v) - dv[e] * (pu - from.u);
    // If a ray is on an edge, the triangle owns the ray if the shifted ray is inside. u or v
    // decides: the one whose axis comes first in the order x, y, z, because its shift is larger.
    const bool u_first = u_index(axis) < v_index(axis);
    const bool owned = u_first ? (dv[e] < 0 || (dv[e] == 0 && du[e] > 0))
                               : (du[e] > 0 || (du[e] == 0 && dv[e] < 0));
    if (!owned) start[e] -= 1;  // now a ray is inside if the values of all edges are >= 0
  }
  // If area > 0, the triangle is counter-clockwise for a viewer who looks against the ray. The ray
  // then leaves the solid.
  const int sign = area > 0 ? -1 : 1;
  const double inverse = 1.0 / static_cast<double>(turn * area);
  const auto [d_min, d_max] = std::minmax({a.depth, b.depth, c.depth});
  // Most rays in the box of a long oblique triangle miss the triangle. In a row of more than
  // kManyRays rays, divisions find the first and the last ray inside. They cost as much as
  // kManyRays tests.
  constexpr int kManyRays = 32;
  for (int v = v0; v <= v1; v++) {
    const int64_t row = int64_t{v - v0} << kSnapBits;
    int64_t w0 = start[0] + du[0] * row, w1 = start[1] + du[1] * row, w2 = start[2] + du[2] * row;
    int64_t first = 0, last = u1 - u0;
    if (last >= kManyRays) {
      const int64_t w[3] = {w0, w1, w2};
      for (int e = 0; e < 3; e++) {
        const int64_t fall = dv[e] << kSnapBits;  // decrease of w from ray to ray
        if (fall > 0)
          last = std::min(last, w[e] < 0 ? -1 : w[e] / fall);
        else if (w[e] < 0)
          first = fall == 0 ? last + 1 : std::max(first, (w[e] + fall + 1) / fall);
      }
      if (first > last) continue;
      w0 -= first * (dv[0] << kSnapBits);
      w1 -= first * (dv[1] << kSnapBits);
      w2 -= first * (dv[2] << kSnapBits);
    }
    for (int u = u0 + static_cast<int>(first); u <= u0 + static_cast<int>(last); u++) {
      if ((w0 | w1 | w2) >= 0) {
        // The value of an edge is the weight of the opposite vertex: w1 is the weight of a, w2 that
        // of b.
        const double wa = static_cast<double>(w1) * inverse, wb = static_cast<double>(w2) * inverse;
        const double depth = c.depth + wa * (a.depth - c.depth) + wb * (b.depth - c.depth);
        f(u, v, std::clamp(depth, d_min, d_max), sign);
      }
      w0 -= dv[0] << kSnapBits;
      w1 -= dv[1] << kSnapBits;
      w2 -= dv[2] << kSnapBits;
    }
  }
}

}  // namespace kibori
