// SPDX-License-Identifier: MIT
// Finds the crossings of lattice rays with triangles. A closed mesh of triangles has no gaps,
// because all corners are on a grid of 2^-16 cells. Therefore, two triangles that share a side use
// the same numbers for it, and a ray through the side belongs to exactly one of them. Internal to
// `reshape`.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <kibori/geometry/vec.h>

namespace kibori {

inline constexpr int kGridBits = 16;
inline constexpr int64_t kGrid = int64_t{1} << kGridBits;  // grid steps per cell

using GridPoint = std::array<int64_t, 3>;

// Returns the grid point nearest to a place in lattice units. Coordinates must be within 2^31
// cells.
inline GridPoint grid_point(const Vec3& at) {
  const auto step = [&](int i) { return std::llround(at[i] * static_cast<double>(kGrid)); };
  return {step(0), step(1), step(2)};
}

// Calls f(u, v, depth, out, weights) for each ray along axis `d` (0, 1, 2: x, y, z) through the
// triangle. u counts rays along axis d + 1, and v along d + 2 (modulo 3). `out` is true if the ray
// leaves the material there. `weights` are the barycentric coordinates for a, b, c. A ray through
// an edge or a corner belongs to one of the triangles around it.
template <class F>
void for_rays_through(const GridPoint& a, const GridPoint& b, const GridPoint& c, int d, F&& f) {
  const auto iu = static_cast<size_t>((d + 1) % 3), iv = static_cast<size_t>((d + 2) % 3),
             id = static_cast<size_t>(d);
  const int64_t area = (b[iu] - a[iu]) * (c[iv] - a[iv]) - (b[iv] - a[iv]) * (c[iu] - a[iu]);
  if (area == 0) return;
  const bool out = area > 0;
  const GridPoint &p = a, &q = out ? b : c, &r = out ? c : b;
  const auto first = [](int64_t low) {  // first node at or above `low`
    return static_cast<int>((low + kGrid / 2 - 1) >> kGridBits);
  };
  const auto last = [](int64_t high) { return static_cast<int>((high - kGrid / 2) >> kGridBits); };
  const int u0 = first(std::min({a[iu], b[iu], c[iu]})), u1 = last(std::max({a[iu], b[iu], c[iu]}));
  const int v0 = first(std::min({a[iv], b[iv], c[iv]})), v1 = last(std::max({a[iv], b[iv], c[iv]}));
  const auto side = [&](const GridPoint& from, const GridPoint& to, int64_t x, int64_t y) {
    return (to[iu] - from[iu]) * (y - from[iv]) - (to[iv] - from[iv]) * (x - from[iu]);
  };
  const auto owns = [&](const GridPoint& from, const GridPoint& to) {
    const int64_t dv = to[iv] - from[iv];
    return dv > 0 || (dv == 0 && to[iu] < from[iu]);
  };
  for (int v = v0; v <= v1; v++)
    for (int u = u0; u <= u1; u++) {
      const int64_t x = u * kGrid + kGrid / 2, y = v * kGrid + kGrid / 2;
      const int64_t wr = side(p, q, x, y), wp = side(q, r, x, y), wq = side(r, p, x, y);
      if (wr < 0 || wp < 0 || wq < 0 || (wr == 0 && !owns(p, q)) || (wp == 0 && !owns(q, r)) ||
          (wq == 0 && !owns(r, p)))
        continue;
      const double whole = static_cast<double>(wr + wp + wq);
      const double sp = static_cast<double>(wp) / whole, sq = static_cast<double>(wq) / whole,
                   sr = static_cast<double>(wr) / whole;
      const double depth = (sp * static_cast<double>(p[id]) + sq * static_cast<double>(q[id]) +
                            sr * static_cast<double>(r[id])) /
                           static_cast<double>(kGrid);
      f(u, v, depth, out, std::array{sp, out ? sq : sr, out ? sr : sq});
    }
}

}  // namespace kibori
