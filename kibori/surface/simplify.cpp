// SPDX-License-Identifier: MIT
#include <kibori/surface/simplify.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <queue>
#include <vector>

namespace kibori {
namespace {

// A triangle may turn by at most acos of this when a corner moves, and no corner may become sharper than a
// sliver.
constexpr double kLeastTurn = 0.3, kLeastShape = 0.02;

// Sum of squared distances to planes, weighted by area: p.A p + 2 b.p + c.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0, x = 0, y = 0, z = 0, c = 0;

  void add_plane(const Vec3& n, double d, double weight) {
    xx += weight * n.x() * n.x();
    xy += weight * n.x() * n.y();
    xz += weight * n.x() * n.z();
    yy += weight * n.y() * n.y();
    yz += weight * n.y() * n.z();
    zz += weight * n.z() * n.z();
    x += weight * d * n.x();
    y += weight * d * n.y();
    z += weight * d * n.z();
    c += weight * d * d;
  }
  void add(const Quadric& q) {
    xx += q.xx, xy += q.xy, xz += q.xz, yy += q.yy, yz += q.yz, zz += q.zz;
    x += q.x, y += q.y, z += q.z, c += q.c;
  }
  double at(const Vec3& p) const {
    return p.x() * (xx * p.x() + 2 * (xy * p.y() + xz * p.z() + x)) +
           p.y() * (yy * p.y() + 2 * (yz * p.z() + y)) + p.z() * (zz * p.z() + 2 * z) + c;
  }
};

// Distance from p to the triangle a b c. Ericson, Real-Time Collision Detection, 5.1.5.
double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
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
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return (bp - (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b)).norm();
  const Vec3 n = ab.cross(ac);
  return std::abs(n.dot(ap)) / n.norm();
}

class Simplifier {
 public:
  Simplifier(const Surface& surface, double tolerance) : surface_(surface), tolerance_(tolerance) {
    const size_t count = surface.vertices.size();
    triangles_ = surface.triangles;
    // Around the middle, so that quadrics keep their digits.
    Box box;
    for (const SurfaceVertex& v : surface.vertices) box.include(position(v));
    points_.reserve(count);
    for (const SurfaceVertex& v : surface.vertices) points_.push_back(position(v) - box.centre());
    around_.resize(count);
    for (uint32_t t = 0; t < triangles_.size(); t++)
      for (const uint32_t v : triangles_[t]) around_[v].push_back(t);
    quadrics_.resize(count);
    moved_.assign(count, 0);
    version_.assign(count, 0);
    for (const SurfaceTriangle& t : triangles_) {
      const Vec3& a = points_[t[0]];
      const Vec3 cross = (points_[t[1]] - a).cross(points_[t[2]] - a);
      const double area = cross.norm();
      if (!(area > 0)) continue;
      for (const uint32_t v : t) quadrics_[v].add_plane(cross / area, -cross.dot(a) / area, area);
    }
  }

  Surface run() {
    for (uint32_t v = 0; v < points_.size(); v++) consider(v);
    while (!queue_.empty()) {
      const Wish wish = queue_.top();
      queue_.pop();
      if (wish.version == version_[wish.vertex]) collapse(wish.vertex);
    }
    return result();
  }

 private:
  struct Wish {
    double cost;
    uint32_t vertex, version;
    bool operator<(const Wish& other) const {  // for a queue with the least cost on top; ties by number
      return cost != other.cost ? cost > other.cost : vertex > other.vertex;
    }
  };
  struct Target {
    double cost;
    uint32_t vertex;
  };

  static Vec3 position(const SurfaceVertex& v) {
    return {static_cast<double>(v.position[0]), static_cast<double>(v.position[1]),
            static_cast<double>(v.position[2])};
  }
  static bool has(const SurfaceTriangle& t, uint32_t v) { return t[0] == v || t[1] == v || t[2] == v; }

  // The vertices around v, each once; false if v is not inside a closed fan.
  bool ring(uint32_t v, std::vector<uint32_t>& out) const {
    out.clear();
    for (const uint32_t t : around_[v])
      for (const uint32_t w : triangles_[t])
        if (w != v) out.push_back(w);
    std::sort(out.begin(), out.end());
    size_t kept = 0;
    for (size_t i = 0; i < out.size(); i += 2) {
      if (i + 1 >= out.size() || out[i] != out[i + 1] || (i + 2 < out.size() && out[i + 2] == out[i]))
        return false;
      out[kept++] = out[i];
    }
    out.resize(kept);
    return kept == around_[v].size();
  }

  // Puts v in the queue by the cheapest neighbour it could be drawn into.
  void consider(uint32_t v) {
    version_[v]++;
    if (around_[v].empty() || moved_[v] >= tolerance_) return;
    double least = std::numeric_limits<double>::infinity();
    for (const uint32_t t : around_[v])
      for (const uint32_t u : triangles_[t])
        if (u != v) least = std::min(least, quadrics_[v].at(points_[u]));
    queue_.push({std::max(0.0, least), v, version_[v]});
  }

  void collapse(uint32_t v) {
    if (!ring(v, ring_v_)) return;
    targets_.clear();
    const SurfaceVertex& own = surface_.vertices[v];
    for (const uint32_t u : ring_v_)
      if (surface_.vertices[u].material == own.material && surface_.vertices[u].paint == own.paint)
        targets_.push_back({quadrics_[v].at(points_[u]), u});
    std::sort(targets_.begin(), targets_.end(), [](const Target& a, const Target& b) {
      return a.cost != b.cost ? a.cost < b.cost : a.vertex < b.vertex;
    });
    for (const Target& target : targets_) {
      double moved = 0;
      if (!fits(v, target.vertex, moved) || !links(v, target.vertex)) continue;
      draw(v, target.vertex, moved);
      return;
    }
  }

  // Link condition: u and v have just the two vertices opposite their edge in common, and those two no
  // triangle with both.
  bool links(uint32_t v, uint32_t u) {
    if (!ring(u, ring_u_)) return false;
    common_.clear();
    std::set_intersection(ring_v_.begin(), ring_v_.end(), ring_u_.begin(), ring_u_.end(),
                          std::back_inserter(common_));
    if (common_.size() != 2) return false;
    const auto joined = [&](uint32_t w) {
      for (const uint32_t t : around_[w])
        if (has(triangles_[t], common_[0]) && has(triangles_[t], common_[1])) return true;
      return false;
    };
    return !(joined(v) && joined(u));
  }

  // Whether v's triangles stay proper and near when it goes to u; `moved`: the bound on all that moved so
  // far.
  bool fits(uint32_t v, uint32_t u, double& moved) const {
    const Vec3 &from = points_[v], &to = points_[u];
    double nearest = std::numeric_limits<double>::infinity();
    for (const uint32_t t : around_[v]) {
      const SurfaceTriangle& corners = triangles_[t];
      if (has(corners, u)) continue;
      Vec3 was[3], is[3];
      for (size_t i = 0; i < 3; i++) {
        was[i] = points_[corners[i]];
        is[i] = corners[i] == v ? to : was[i];
      }
      const Vec3 before = (was[1] - was[0]).cross(was[2] - was[0]),
                 after = (is[1] - is[0]).cross(is[2] - is[0]);
      const double area = after.norm();
      const double longest2 = std::max(
          {(is[1] - is[0]).squaredNorm(), (is[2] - is[1]).squaredNorm(), (is[0] - is[2]).squaredNorm()});
      if (!(area > kLeastShape * longest2) || after.dot(before) < kLeastTurn * area * before.norm())
        return false;
      nearest = std::min(nearest, distance_to_triangle(from, is[0], is[1], is[2]));
    }
    moved = std::max(moved_[v], moved_[u]) + nearest;
    return moved <= tolerance_;
  }

  void draw(uint32_t v, uint32_t u, double moved) {
    for (const uint32_t t : around_[v]) {
      SurfaceTriangle& corners = triangles_[t];
      if (has(corners, u)) {
        for (const uint32_t w : corners)
          if (w != v) std::erase(around_[w], t);
        corners = {0, 0, 0};
      } else {
        std::replace(corners.begin(), corners.end(), v, u);
        around_[u].push_back(t);
      }
    }
    around_[v].clear();
    around_[v].shrink_to_fit();
    quadrics_[u].add(quadrics_[v]);
    moved_[u] = moved;
    if (!ring(u, ring_u_)) return;
    for (const uint32_t w : ring_u_) consider(w);
    consider(u);
  }

  Surface result() const {
    Surface out;
    std::vector<uint32_t> number(points_.size());
    for (uint32_t v = 0; v < points_.size(); v++)
      if (!around_[v].empty()) {
        number[v] = static_cast<uint32_t>(out.vertices.size());
        out.vertices.push_back(surface_.vertices[v]);
      }
    for (const SurfaceTriangle& t : triangles_)
      if (t[0] != t[1]) out.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    return out;
  }

  const Surface& surface_;
  const double tolerance_;
  std::vector<SurfaceTriangle> triangles_;  // {0, 0, 0}: gone
  std::vector<Vec3> points_;
  std::vector<std::vector<uint32_t>> around_;  // triangles of each vertex
  std::vector<Quadric> quadrics_;
  std::vector<double> moved_;  // bound on how far the surface near each vertex is from the old one
  std::vector<uint32_t> version_;
  std::priority_queue<Wish> queue_;
  std::vector<uint32_t> ring_v_, ring_u_, common_;
  std::vector<Target> targets_;
};

}  // namespace

Surface simplify(const Surface& surface, double tolerance_mm) {
  if (!(tolerance_mm > 0)) return surface;
  return Simplifier(surface, tolerance_mm).run();
}

}  // namespace kibori
