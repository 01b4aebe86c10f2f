// SPDX-License-Identifier: MIT
#include <kibori/surface/simplify.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <queue>
#include <vector>

#include <kibori/geometry/triangle_distance.h>

namespace kibori {
namespace {

// A triangle must not turn too far when a corner moves: kMinTurn is the minimum cosine of that
// angle. kMinShape prevents slivers: it is the minimum of twice the area, divided by the square of
// the longest side.
constexpr double kMinTurn = 0.3, kMinShape = 0.02;

// The distance between two surfaces is measured only at some points, and may be larger between
// them. Therefore, only this share of the tolerance is used.
constexpr double kShare = 0.6;

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

class Simplifier {
 public:
  Simplifier(const Surface& surface, double tolerance) : surface_(surface), tolerance_(tolerance) {
    const size_t count = surface.vertices.size();
    triangles_ = surface.triangles;
    // Coordinates are relative to the middle of the surface. Otherwise quadrics would lose digits.
    Box box;
    for (const SurfaceVertex& v : surface.vertices) box.include(position(v));
    points_.reserve(count);
    for (const SurfaceVertex& v : surface.vertices) points_.push_back(position(v) - box.centre());
    around_.resize(count);
    for (uint32_t t = 0; t < triangles_.size(); t++)
      for (const uint32_t v : triangles_[t]) around_[v].push_back(t);
    quadrics_.resize(count);
    moved_.assign(triangles_.size(), 0);
    version_.assign(count, 0);
    for (const SurfaceTriangle& t : triangles_) {
      // To keep a colour border in place, the quadrics of its vertices get a plane through it,
      // perpendicular to the surface.
      for (size_t i = 0; i < 3; i++) {
        const uint32_t p = t[i], q = t[(i + 1) % 3];
        if (!same_color(p, q) || same_color(p, t[(i + 2) % 3])) continue;
        const Vec3 edge = points_[q] - points_[p];
        const Vec3 wall = edge.cross((points_[t[(i + 2) % 3]] - points_[p]).cross(edge));
        const double length = wall.norm();
        if (!(length > 0)) continue;
        for (const uint32_t v : {p, q})
          quadrics_[v].add_plane(wall / length, -wall.dot(points_[p]) / length, edge.squaredNorm());
      }
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
    // For a queue with the lowest cost on top; equal costs by vertex number.
    bool operator<(const Wish& other) const {
      return cost != other.cost ? cost > other.cost : vertex > other.vertex;
    }
  };
  struct Target {
    double cost;
    uint32_t vertex;
  };

  struct Face {
    Vec3 corner[3];
    Vec3 cross() const { return (corner[1] - corner[0]).cross(corner[2] - corner[0]); }
    double longest2() const {
      return std::max({(corner[1] - corner[0]).squaredNorm(), (corner[2] - corner[1]).squaredNorm(),
                       (corner[0] - corner[2]).squaredNorm()});
    }
    double distance(const Vec3& p) const {
      return distance_to_triangle(p, corner[0], corner[1], corner[2]);
    }
  };

  static Vec3 position(const SurfaceVertex& v) {
    return {static_cast<double>(v.position[0]), static_cast<double>(v.position[1]),
            static_cast<double>(v.position[2])};
  }
  bool same_color(uint32_t a, uint32_t b) const {
    const SurfaceVertex &p = surface_.vertices[a], &q = surface_.vertices[b];
    return p.material == q.material && with_mask(p.paint, 0) == with_mask(q.paint, 0);
  }
  static bool has(const SurfaceTriangle& t, uint32_t v) {
    return t[0] == v || t[1] == v || t[2] == v;
  }

  // The vertices around v, each once. Returns false if v is not inside a closed fan.
  bool ring(uint32_t v, std::vector<uint32_t>& out) const {
    out.clear();
    for (const uint32_t t : around_[v])
      for (const uint32_t w : triangles_[t])
        if (w != v) out.push_back(w);
    std::sort(out.begin(), out.end());
    size_t kept = 0;
    for (size_t i = 0; i < out.size(); i += 2) {
      if (i + 1 >= out.size() || out[i] != out[i + 1] ||
          (i + 2 < out.size() && out[i + 2] == out[i]))
        return false;
      out[kept++] = out[i];
    }
    out.resize(kept);
    return kept == around_[v].size();
  }

  // Queues v with the cost of its cheapest merge into a neighbour.
  void consider(uint32_t v) {
    version_[v]++;
    if (around_[v].empty()) return;
    double min = std::numeric_limits<double>::infinity();
    for (const uint32_t t : around_[v])
      for (const uint32_t u : triangles_[t])
        if (u != v) min = std::min(min, quadrics_[v].at(points_[u]));
    queue_.push({std::max(0.0, min), v, version_[v]});
  }

  void collapse(uint32_t v) {
    if (!ring(v, ring_v_)) return;
    targets_.clear();
    // A vertex on a colour border may only move along the border.
    border_.clear();
    bool on_border = false;
    for (const uint32_t t : around_[v])
      for (size_t i = 0; i < 3; i++) {
        const uint32_t p = triangles_[t][i], q = triangles_[t][(i + 1) % 3],
                       r = triangles_[t][(i + 2) % 3];
        on_border |= !same_color(v, p);
        if ((p == v || q == v) && same_color(p, q) && !same_color(p, r))
          border_.push_back(p == v ? q : p);
      }
    for (const uint32_t u : ring_v_)
      if (on_border ? std::find(border_.begin(), border_.end(), u) != border_.end()
                    : same_color(u, v))
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

  // Link condition: u and v have exactly two common neighbours, which are opposite their edge. No
  // triangle contains both of these.
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

  // True if v may move to u: no triangle of v becomes degenerate or turns over, and the surface
  // stays within the tolerance. `moved` receives a bound on the distance of the surface there from
  // the original.
  bool fits(uint32_t v, uint32_t u, double& moved) {
    const Vec3 &from = points_[v], &to = points_[u];
    double before_now = 0;
    fan_.clear();
    for (const uint32_t t : around_[v]) {
      before_now = std::max(before_now, moved_[t]);
      const SurfaceTriangle& corners = triangles_[t];
      if (has(corners, u)) continue;
      Face is;
      Vec3 was[3];
      for (size_t i = 0; i < 3; i++) {
        was[i] = points_[corners[i]];
        is.corner[i] = corners[i] == v ? to : was[i];
      }
      const Vec3 before = (was[1] - was[0]).cross(was[2] - was[0]), after = is.cross();
      const double area = after.norm();
      if (!(area > kMinShape * is.longest2()) ||
          after.dot(before) < kMinTurn * area * before.norm())
        return false;
      fan_.push_back(is);
    }
    // The distance between the old fan of triangles around v and the new one. It is measured from v
    // and the middles of the old fan's inner sides to the new fan. In the other direction, it is
    // measured from the middles of the new triangles and of their inner sides. Points where an old
    // side crosses a new one are measured, too.
    double apart = to_fan(from);
    if (before_now + apart > kShare * tolerance_) return false;
    for (const uint32_t w : ring_v_) apart = std::max(apart, to_fan(0.5 * (from + points_[w])));
    apart = std::max(apart, to_border(v, u));
    for (const Face& face : fan_) {
      const Vec3 middle = (face.corner[0] + face.corner[1] + face.corner[2]) / 3;
      apart = std::max(apart, from_fan(v, middle));
      for (size_t i = 0; i < 3; i++)
        if (face.corner[i] == to) {
          const Vec3& end = face.corner[(i + 1) % 3];
          apart = std::max(apart, from_fan(v, 0.5 * (to + end)));
          for (const uint32_t w : ring_v_) {
            const Crossing c = crossing(from, points_[w], to, end);
            // The fans may be closer to each other there than these two sides are.
            if ((c.here - c.there).norm() > apart)
              apart = std::max({apart, to_fan(c.here), from_fan(v, c.there)});
          }
        }
    }
    moved = before_now + apart;
    return moved <= kShare * tolerance_;
  }

  // Distance from v to the colour border after the merge: the line from u to v's other neighbour on
  // the border.
  double to_border(uint32_t v, uint32_t u) const {
    if (border_.empty()) return 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (const uint32_t w : border_)
      if (w != u)
        nearest =
            std::min(nearest, distance_to_triangle(points_[v], points_[u], points_[w], points_[w]));
    return nearest;
  }

  // The nearest points of the lines a b and c d. If the lines are parallel, or if one of the points
  // is not inside its segment, both results are a.
  struct Crossing {
    Vec3 here, there;
  };
  static Crossing crossing(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const Vec3 along = b - a, across = d - c, between = c - a;
    const double aa = along.squaredNorm(), ac = along.dot(across), cc = across.squaredNorm();
    const double det = aa * cc - ac * ac;
    if (!(det > 1e-12 * aa * cc)) return {a, a};
    const double s = (along.dot(between) * cc - across.dot(between) * ac) / det;
    const double t = (along.dot(between) * ac - across.dot(between) * aa) / det;
    if (!(s > 0 && s < 1 && t > 0 && t < 1)) return {a, a};
    return {a + s * along, c + t * across};
  }

  double to_fan(const Vec3& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Face& face : fan_) nearest = std::min(nearest, face.distance(p));
    return nearest;
  }

  // Distance from p to the current triangles around v.
  double from_fan(uint32_t v, const Vec3& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const uint32_t t : around_[v]) {
      const SurfaceTriangle& c = triangles_[t];
      nearest =
          std::min(nearest, distance_to_triangle(p, points_[c[0]], points_[c[1]], points_[c[2]]));
    }
    return nearest;
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
        moved_[t] = moved;
        around_[u].push_back(t);
      }
    }
    around_[v].clear();
    around_[v].shrink_to_fit();
    quadrics_[u].add(quadrics_[v]);
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
  std::vector<SurfaceTriangle> triangles_;  // {0, 0, 0}: removed
  std::vector<Vec3> points_;
  std::vector<std::vector<uint32_t>> around_;  // triangles of each vertex
  std::vector<Quadric> quadrics_;
  std::vector<double> moved_;  // per triangle: bound on its distance from the old surface
  std::vector<uint32_t> version_;
  std::priority_queue<Wish> queue_;
  std::vector<uint32_t> ring_v_, ring_u_, common_, border_;
  std::vector<Target> targets_;
  std::vector<Face> fan_;
};

}  // namespace

Surface simplify(const Surface& surface, double tolerance_mm) {
  if (!(tolerance_mm > 0)) return surface;
  return Simplifier(surface, tolerance_mm).run();
}

}  // namespace kibori
