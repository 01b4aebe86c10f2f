// SPDX-License-Identifier: MIT
#include <kibori/geometry/mesh_info.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kibori {
namespace {

class Sets {  // union-find
 public:
  explicit Sets(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), size_t{0});
  }
  size_t find(size_t a) {
    while (parent_[a] != a) a = parent_[a] = parent_[parent_[a]];
    return a;
  }
  bool unite(size_t a, size_t b) {  // false if they were already one set
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<size_t> parent_;
};

struct Side {  // of a triangle, from corner `corner` to the next
  uint32_t low, high;
  bool forward;  // low first
  size_t triangle;
  size_t corner;
};

}  // namespace

MeshInfo mesh_info(const Surface& surface, size_t degenerate) {
  MeshInfo info;
  info.triangles = surface.triangles.size();
  info.degenerate = degenerate;
  const auto at = [&](uint32_t v) {
    const auto& p = surface.vertices[v].position;
    return Vec3(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
  };
  for (const SurfaceTriangle& t : surface.triangles)
    for (const uint32_t v : t) info.bounds.include(at(v));
  if (surface.triangles.empty()) return info;

  // Coordinates are relative to the middle. Otherwise a mesh far from the origin would lose digits.
  const Vec3 middle = info.bounds.centre();
  Vec3 by_volume = Vec3::Zero(), by_area = Vec3::Zero();
  for (const SurfaceTriangle& t : surface.triangles) {
    const Vec3 a = at(t[0]) - middle, b = at(t[1]) - middle, c = at(t[2]) - middle;
    const double volume = a.dot(b.cross(c)) / 6, area = (b - a).cross(c - a).norm() / 2;
    info.volume_mm3 += volume;
    info.area_mm2 += area;
    by_volume += volume / 4 * (a + b + c);
    by_area += area / 3 * (a + b + c);
  }

  std::vector<Side> sides;
  sides.reserve(3 * surface.triangles.size());
  for (size_t i = 0; i < surface.triangles.size(); i++)
    for (size_t k = 0; k < 3; k++) {
      const uint32_t a = surface.triangles[i][k], b = surface.triangles[i][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), a < b, i, k});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.low != b.low     ? a.low < b.low
           : a.high != b.high ? a.high < b.high
                              : a.triangle < b.triangle;
  });
  Sets pieces(surface.triangles.size());
  Sets fans(3 * surface.triangles.size());  // corners of triangles, united across edges
  info.components = surface.triangles.size();
  size_t fan_count = 3 * surface.triangles.size();
  for (size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    size_t forward = 0;
    for (end = begin; end < sides.size() && sides[end].low == sides[begin].low &&
                      sides[end].high == sides[begin].high;
         end++) {
      forward += sides[end].forward;
      info.components -= pieces.unite(sides[begin].triangle, sides[end].triangle);
    }
    const size_t backward = end - begin - forward;
    info.open_edges += std::max(forward, backward) - std::min(forward, backward);
    info.overfull_edges += end - begin > 2;
    if (end - begin != 2) continue;
    const Side &a = sides[begin], &b = sides[begin + 1];
    // At each end of the edge, the corners of the two triangles belong to one fan.
    const auto corner = [](const Side& s, bool low) {
      return 3 * s.triangle + (s.forward == low ? s.corner : (s.corner + 1) % 3);
    };
    for (const bool low : {true, false}) fan_count -= fans.unite(corner(a, low), corner(b, low));
  }
  std::vector<bool> used(surface.vertices.size());
  for (const SurfaceTriangle& t : surface.triangles)
    for (const uint32_t v : t) used[v] = true;
  const auto vertices = static_cast<size_t>(std::count(used.begin(), used.end(), true));
  info.closed = info.open_edges == 0;
  info.manifold =
      info.closed && info.overfull_edges == 0 && fan_count == vertices && degenerate == 0;
  info.centroid_mm =
      middle + (info.closed && std::abs(info.volume_mm3) > 0 ? Vec3(by_volume / info.volume_mm3)
                : info.area_mm2 > 0                          ? Vec3(by_area / info.area_mm2)
                                                             : Vec3(Vec3::Zero()));
  return info;
}

}  // namespace kibori
