// SPDX-License-Identifier: MIT
#include <kibori/spline/profile.h>

#include <algorithm>
#include <cstddef>

namespace kibori {
namespace {

// Twice the area of abc; positive if abc is counter-clockwise.
double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// True if p, which is on the line through a and b, is between them.
bool between(const Vec2& a, const Vec2& b, const Vec2& p) {
  return std::min(a.x(), b.x()) <= p.x() && p.x() <= std::max(a.x(), b.x()) &&
         std::min(a.y(), b.y()) <= p.y() && p.y() <= std::max(a.y(), b.y());
}

bool meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const double ac = turn(a, b, c), ad = turn(a, b, d), ca = turn(c, d, a), cb = turn(c, d, b);
  if (((ac > 0 && ad < 0) || (ac < 0 && ad > 0)) && ((ca > 0 && cb < 0) || (ca < 0 && cb > 0)))
    return true;
  return (ac == 0 && between(a, b, c)) || (ad == 0 && between(a, b, d)) ||
         (ca == 0 && between(c, d, a)) || (cb == 0 && between(c, d, b));
}

}  // namespace

double signed_area(const std::vector<Vec2>& polygon) {
  double sum = 0;
  for (size_t i = 1; i + 1 < polygon.size(); i++)
    sum += turn(polygon[0], polygon[i], polygon[i + 1]);
  return sum / 2;
}

bool crosses_itself(const std::vector<Vec2>& polygon) {
  const size_t n = polygon.size();
  if (n < 3) return false;
  const auto corner = [&](size_t i) -> const Vec2& { return polygon[i % n]; };
  // Sides are sorted by their lower x, so that each is compared only with sides of overlapping x.
  std::vector<size_t> order(n);
  for (size_t i = 0; i < n; i++) order[i] = i;
  const auto low = [&](size_t i) { return std::min(corner(i).x(), corner(i + 1).x()); };
  const auto high = [&](size_t i) { return std::max(corner(i).x(), corner(i + 1).x()); };
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return low(a) != low(b) ? low(a) < low(b) : a < b; });
  for (size_t k = 0; k < n; k++)
    for (size_t l = k + 1; l < n && low(order[l]) <= high(order[k]); l++) {
      size_t i = order[k], j = order[l];
      if ((j + 1) % n == i) std::swap(i, j);
      const Vec2 &a = corner(i), &b = corner(i + 1), &c = corner(j), &d = corner(j + 1);
      if ((i + 1) % n == j) {  // neighbours: the second may not reverse along the first
        if (turn(a, b, d) == 0 && (a - b).dot(d - b) > 0) return true;
      } else if (meet(a, b, c, d)) {
        return true;
      }
    }
  return false;
}

std::vector<std::array<uint32_t, 3>> triangulate(const std::vector<Vec2>& polygon) {
  const size_t n = polygon.size();
  if (n < 3) return {};
  std::vector<size_t> before(n), after(n);
  for (size_t i = 0; i < n; i++) {
    before[i] = (i + n - 1) % n;
    after[i] = (i + 1) % n;
  }
  const auto turn_at = [&](size_t i) {
    return turn(polygon[before[i]], polygon[i], polygon[after[i]]);
  };
  const auto is_ear = [&](size_t i) {
    if (!(turn_at(i) > 0)) return false;
    const Vec2 &a = polygon[before[i]], &b = polygon[i], &c = polygon[after[i]];
    const Vec2 min = a.cwiseMin(b).cwiseMin(c), max = a.cwiseMax(b).cwiseMax(c);
    for (size_t k = after[after[i]]; k != before[i]; k = after[k]) {
      const Vec2& p = polygon[k];
      if (p.x() < min.x() || p.x() > max.x() || p.y() < min.y() || p.y() > max.y()) continue;
      // If the polygon reaches into the ear, then one of its reflex corners is in the ear. So other
      // corners need no check.
      if (turn_at(k) > 0) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  };
  std::vector<std::array<uint32_t, 3>> triangles;
  size_t left = n, at = 0, refused = 0;
  while (left > 3) {
    // Because of rounding, the check can refuse all remaining corners. Then any corner is clipped,
    // so that the mesh is closed.
    if (refused < left && !is_ear(at)) {
      refused++;
      at = after[at];
      continue;
    }
    triangles.push_back({static_cast<uint32_t>(before[at]), static_cast<uint32_t>(at),
                         static_cast<uint32_t>(after[at])});
    after[before[at]] = after[at];
    before[after[at]] = before[at];
    at = after[after[at]];
    left--;
    refused = 0;
  }
  triangles.push_back({static_cast<uint32_t>(before[at]), static_cast<uint32_t>(at),
                       static_cast<uint32_t>(after[at])});
  return triangles;
}

}  // namespace kibori
