// SPDX-License-Identifier: MIT
#include <kibori/solid/mesh_solid.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include <kibori/dexel/normal_code.h>
#include <kibori/solid/crossings.h>

namespace kibori {
namespace {

// Neighbouring prisms may have a gap between them because of rounding. A gap thinner than this
// [lattice units] is closed.
constexpr float kSeam = 1e-3f;
// A prism is edge-on if the ray and the motion are both parallel to its triangle, within this sine
// of the angle. It then has no interval, because the prisms of its neighbours have it. With a
// larger value, the sweep would have thin slits. With a smaller one, the interval would be rounding
// error.
constexpr double kEdgeOn = 1e-12;
// A mesh with fewer triangles is not sorted into tiles.
constexpr size_t kWorthBins = 64;

uint32_t code_of(const Vec3& normal, Axis axis) {
  return encode_normal(normal[u_index(axis)], normal[v_index(axis)], normal[depth_index(axis)]);
}

// Narrows [lo, hi] to where slope x + offset >= 0.
void clip(double slope, double offset, double& lo, double& hi) {
  if (slope > 0)
    lo = std::max(lo, -offset / slope);
  else if (slope < 0)
    hi = std::min(hi, -offset / slope);
  else if (offset < 0)
    hi = lo - 1;
}

// Dot products of a vector with (o - corner), where o is the origin of a ray of a tile. The
// products of a column or of a row are computed once.
class TileDots {
 public:
  // For the rays of `seen`, which belong to one tile.
  TileDots(const Vec3& vector, const Vec3& corner, Axis axis, const RayRect& seen) : axis_(axis) {
    const int ui = u_index(axis), vi = v_index(axis), di = depth_index(axis);
    for (int u = seen.u0; u < seen.u1; u++)
      of_u_[u - seen.u0] = vector[ui] * (u + 0.5 - corner[ui]);
    for (int v = seen.v0; v < seen.v1; v++)
      of_v_[v - seen.v0] = vector[vi] * (v + 0.5 - corner[vi]);
    of_depth_ = vector[di] * (0 - corner[di]);
  }
  // For the ray (u, v), counted from the first ray of `seen`. The order of the additions is that of
  // Eigen, so the bits are the same.
  double at(int u, int v) const {
    switch (axis_) {
      case Axis::x:
        return of_depth_ + (of_u_[u] + of_v_[v]);
      case Axis::y:
        return of_v_[v] + (of_depth_ + of_u_[u]);
      case Axis::z:
        return of_u_[u] + (of_v_[v] + of_depth_);
    }
    return 0;
  }

 private:
  Axis axis_;
  double of_u_[kTileSide], of_v_[kTileSide], of_depth_;
};

// The area of the (u, v) plane that a triangle covers while it moves. It is a convex polygon. Its
// sides are parallel to the triangle's edges or to the motion. For each row, it gives the rays that
// can meet the triangle.
class SweptShadow {
 public:
  SweptShadow(const std::array<const Vec3*, 3>& corner, const Vec3& motion, int ui, int vi) {
    const double mu = motion[ui], mv = motion[vi];
    for (size_t e = 0; e < 4; e++) {
      const Vec3 along = e < 3 ? Vec3(*corner[(e + 1) % 3] - *corner[e]) : motion;
      Strip& strip = strips_[e];
      strip.a = -along[vi];
      strip.b = along[ui];
      for (int i = 0; i < 3; i++) {
        const double at = strip.a * (*corner[i])[ui] + strip.b * (*corner[i])[vi];
        strip.lo = i ? std::min(strip.lo, at) : at;
        strip.hi = i ? std::max(strip.hi, at) : at;
      }
      const double moved = strip.a * mu + strip.b * mv,
                   slack = kSlack * (std::abs(strip.a) + std::abs(strip.b));
      strip.lo += std::min(moved, 0.0) - slack;
      strip.hi += std::max(moved, 0.0) + slack;
      strip.per_a = strip.a != 0 ? 1 / strip.a : 0;
    }
  }

  // Narrows [u0, u1] to the rays of row v that can meet the triangle.
  void narrow(int v, int& u0, int& u1) const {
    const double at = v + 0.5;
    double lo = u0 + 0.5, hi = u1 + 0.5;
    for (const Strip& strip : strips_) {
      const double from = strip.lo - strip.b * at, to = strip.hi - strip.b * at;
      if (std::abs(strip.a) < kLevel) {
        if (from > kLevel * kMaxNodesPerAxis || to < -kLevel * kMaxNodesPerAxis) hi = lo - 1;
        continue;
      }
      lo = std::max(lo, strip.per_a * (strip.a > 0 ? from : to));
      hi = std::min(hi, strip.per_a * (strip.a > 0 ? to : from));
    }
    u0 = static_cast<int>(std::ceil(lo - 0.5));
    u1 = hi < lo ? u0 - 1 : static_cast<int>(std::floor(hi - 0.5));
  }

 private:
  // The polygon is enlarged by kSlack cells. A side counts as parallel to the rows if |a| < kLevel.
  static constexpr double kSlack = 1e-6, kLevel = 1e-9;
  struct Strip {
    double a, b, per_a, lo, hi;  // lo <= a u + b v <= hi
  };
  Strip strips_[4];
};

// The rays of a rectangle that can meet a box.
RayRect within(const RayRect& rect, const Box& box, int ui, int vi) {
  const auto first = [](double low, int at) {
    return low > at ? static_cast<int>(std::min(std::ceil(low - 0.5), at + 1.0 * kTileSide)) : at;
  };
  const auto end = [](double high, int at) {
    return high < at ? static_cast<int>(std::max(std::floor(high + 0.5), at - 1.0 * kTileSide))
                     : at;
  };
  return {first(box.min[ui], rect.u0), end(box.max[ui], rect.u1), first(box.min[vi], rect.v0),
          end(box.max[vi], rect.v1)};
}

}  // namespace

SweptMesh::SweptMesh(std::shared_ptr<const TriangleMesh> mesh, const Pose& start,
                     const LatticeVector& motion, const Lattice& lattice)
    : mesh_(std::move(mesh)),
      mirrored_(start.frame.determinant() < 0),
      motion_(motion.units),
      lattice_(lattice.whole().units) {
  points_.reserve(mesh_->vertices.size());
  for (const Vec3& p : mesh_->vertices) {
    points_.push_back(lattice.to_lattice(start.to_world(p)).units);
    bounds_.include(points_.back());
    bounds_.include(Vec3(points_.back() + motion_));
  }
  faces_.reserve(mesh_->triangles.size());
  for (uint32_t i = 0; i < mesh_->triangles.size(); i++) faces_.push_back(face_of(i));
  if (mesh_->triangles.size() < kWorthBins) return;
  for (const Axis axis : kAxes) sort_into(bins_[static_cast<size_t>(axis)], axis, lattice);
}

std::array<const Vec3*, 3> SweptMesh::corners_of(uint32_t triangle) const {
  auto [a, b, c] = mesh_->triangles[triangle];
  if (mirrored_) std::swap(b, c);
  return {&points_[a], &points_[b], &points_[c]};
}

SweptMesh::Face SweptMesh::face_of(uint32_t triangle) const {
  const std::array<const Vec3*, 3> corner = corners_of(triangle);
  Face face;
  face.normal = (*corner[1] - *corner[0]).cross(*corner[2] - *corner[0]);
  face.along_motion = -face.normal.dot(motion_);
  face.edge_on = kEdgeOn * face.normal.norm();
  for (size_t e = 0; e < 3; e++) {
    const Vec3 edge = *corner[(e + 1) % 3] - *corner[e];
    face.edge_normal[e] = face.normal.cross(edge);
    face.edge_along_motion[e] = -face.edge_normal[e].dot(motion_);
    // Silhouette normals of the prism's sides, per edge.
    face.side[e] = edge.cross(motion_);
    if (face.side[e].dot(*corner[(e + 2) % 3] - *corner[e]) > 0) face.side[e] = -face.side[e];
  }
  return face;
}

std::array<double, 4> SweptMesh::swept_rect(uint32_t triangle, Axis axis) const {
  const std::array<const Vec3*, 3> corner = corners_of(triangle);
  const Vec3 &a = *corner[0], &b = *corner[1], &c = *corner[2];
  const int ui = u_index(axis), vi = v_index(axis);
  const auto [u_lo, u_hi] = std::minmax({a[ui], b[ui], c[ui]});
  const auto [v_lo, v_hi] = std::minmax({a[vi], b[vi], c[vi]});
  return {u_lo + std::min(motion_[ui], 0.0), u_hi + std::max(motion_[ui], 0.0),
          v_lo + std::min(motion_[vi], 0.0), v_hi + std::max(motion_[vi], 0.0)};
}

void SweptMesh::sort_into(Bins& bins, Axis axis, const Lattice& lattice) const {
  const Box whole = lattice.whole().units;
  const auto tile_of = [&](double at, int index) {
    return static_cast<int>(
        std::floor(std::clamp(at, whole.min[index], whole.max[index] - 1) / kTileSide));
  };
  const int ui = u_index(axis), vi = v_index(axis);
  bins.u = tile_of(bounds_.min[ui] - 1, ui);
  bins.v = tile_of(bounds_.min[vi] - 1, vi);
  bins.across = tile_of(bounds_.max[ui] + 1, ui) - bins.u + 1;
  bins.down = tile_of(bounds_.max[vi] + 1, vi) - bins.v + 1;
  bins.rects.reserve(mesh_->triangles.size());
  for (uint32_t i = 0; i < mesh_->triangles.size(); i++) bins.rects.push_back(swept_rect(i, axis));
  // The first pass counts, the second one stores. A triangle that touches two tiles belongs to
  // both.
  const auto for_bins = [&](auto&& f) {
    for (uint32_t i = 0; i < mesh_->triangles.size(); i++) {
      const auto [u_lo, u_hi, v_lo, v_hi] = bins.rects[i];
      const int tu0 = tile_of(u_lo - 1, ui), tu1 = tile_of(u_hi + 1, ui),
                tv0 = tile_of(v_lo - 1, vi), tv1 = tile_of(v_hi + 1, vi);
      for (int v = std::max(tv0, bins.v); v <= std::min(tv1, bins.v + bins.down - 1); v++)
        for (int u = std::max(tu0, bins.u); u <= std::min(tu1, bins.u + bins.across - 1); u++)
          f(static_cast<size_t>((v - bins.v) * bins.across + u - bins.u), i);
    }
  };
  bins.first.assign(static_cast<size_t>(bins.across) * static_cast<size_t>(bins.down) + 1, 0);
  for_bins([&](size_t bin, uint32_t) { bins.first[bin + 1]++; });
  for (size_t i = 1; i < bins.first.size(); i++) bins.first[i] += bins.first[i - 1];
  bins.triangles.resize(bins.first.back());
  std::vector<uint32_t> next(bins.first.begin(), bins.first.end() - 1);
  for_bins([&](size_t bin, uint32_t triangle) { bins.triangles[next[bin]++] = triangle; });
}

void SweptMesh::fill(const RayTile& rays, TileIntervals& all) const {
  struct Crossing {
    float depth;
    int sign;
    uint32_t code;
    bool operator<(const Crossing& other) const {
      return std::tie(depth, sign, code) < std::tie(other.depth, other.sign, other.code);
    }
  };
  thread_local std::array<std::vector<Crossing>, kTileRays> crossings_of;
  for (auto& list : crossings_of) list.clear();
  const Bins& bins = bins_[static_cast<size_t>(rays.axis)];
  const int tile_u = tile_of_node(rays.u0) - bins.u, tile_v = tile_of_node(rays.v0) - bins.v;
  // A tile without a bin checks all triangles.
  const bool binned = place_in_tile(rays.u0) == 0 && place_in_tile(rays.v0) == 0 && tile_u >= 0 &&
                      tile_v >= 0 && tile_u < bins.across && tile_v < bins.down;
  const size_t bin = binned ? static_cast<size_t>(tile_v * bins.across + tile_u) : 0,
               begins = binned ? bins.first[bin] : 0,
               ends = binned ? bins.first[bin + 1] : mesh_->triangles.size();

  const Axis axis = rays.axis;
  const int ui = u_index(axis), vi = v_index(axis), di = depth_index(axis);
  const RayRect rect{rays.u0, rays.u0 + kTileSide, rays.v0, rays.v0 + kTileSide},
      seen = within(rect, lattice_, ui, vi);
  if (seen.u0 >= seen.u1 || seen.v0 >= seen.v1) return;
  const bool moving = motion_.squaredNorm() > kNoSweep * kNoSweep;
  for (size_t i = begins; i < ends; i++) {
    const auto number = binned ? bins.triangles[i] : static_cast<uint32_t>(i);
    const std::array<const Vec3*, 3> corner = corners_of(number);
    const Vec3 &a = *corner[0], &b = *corner[1], &c = *corner[2];
    const auto [u_lo, u_hi, v_lo, v_hi] = binned ? bins.rects[number] : swept_rect(number, axis);
    if (u_hi < seen.u0 || u_lo > seen.u1 || v_hi < seen.v0 || v_lo > seen.v1) continue;
    const Face& face = faces_[number];
    const Vec3& normal = face.normal;
    std::optional<uint32_t> face_code;  // computed on first use
    const auto code_of_face = [&] {
      if (!face_code) face_code = code_of(normal, axis);
      return *face_code;
    };
    for_crossings(snap({a}, axis), snap({b}, axis), snap({c}, axis), axis, seen,
                  [&](int u, int v, double depth, int sign) {
                    const auto slot =
                        static_cast<size_t>((v - rays.v0) * kTileSide + (u - rays.u0));
                    // The depth on the triangle's exact plane, before rounding to the grid. The
                    // prism of this triangle begins there, too.
                    Vec3 o = Vec3::Zero();
                    o[ui] = u + 0.5;
                    o[vi] = v + 0.5;
                    const auto [low, high] = std::minmax({a[di], b[di], c[di]});
                    const double exact = normal.dot(a - o) / normal[di];
                    depth = std::isfinite(exact) ? std::clamp(exact, low, high) : depth;
                    crossings_of[slot].push_back({static_cast<float>(depth), sign, code_of_face()});
                  });
    if (!moving) continue;
    // Depth t along a ray and motion parameter s: where the ray meets the plane of the moving
    // triangle, t depends linearly on s. The triangle's three edges and 0 <= s <= 1 clip this line.
    // The prism's interval is the range of t on the rest.
    const double alpha = normal[di], beta = face.along_motion;
    if (std::abs(alpha) + std::abs(beta) < face.edge_on) continue;
    const int u0 = std::max(seen.u0, static_cast<int>(std::floor(u_lo - 0.5)));
    const int u1 = std::min(seen.u1 - 1, static_cast<int>(std::ceil(u_hi - 0.5)));
    const int v0 = std::max(seen.v0, static_cast<int>(std::floor(v_lo - 0.5)));
    const int v1 = std::min(seen.v1 - 1, static_cast<int>(std::ceil(v_hi - 0.5)));
    if (u0 > u1 || v0 > v1) continue;
    // A triangle that slides in its own plane adds nothing to the mesh. A prism beyond the lattice
    // in depth is skipped too.
    if (beta == 0) continue;
    const auto [d_lo, d_hi] = std::minmax({a[di], b[di], c[di]});
    if (d_hi + std::max(motion_[di], 0.0) < lattice_.min[di] - 1 ||
        d_lo + std::min(motion_[di], 0.0) > lattice_.max[di] + 1)
      continue;
    const bool by_s = std::abs(alpha) >= std::abs(beta);
    const double step = by_s ? -beta / alpha : -alpha / beta;
    std::optional<uint32_t> side_code[3];  // computed on first use
    double slope[3], per[3];
    const RayRect near{u0, u1 + 1, v0, v1 + 1};
    const TileDots across(normal, a, axis, near),
        edge_across[3]{{face.edge_normal[0], a, axis, near},
                       {face.edge_normal[1], b, axis, near},
                       {face.edge_normal[2], c, axis, near}};
    for (int e = 0; e < 3; e++) {
      const double per_t = face.edge_normal[e][di], per_s = face.edge_along_motion[e];
      slope[e] = by_s ? per_s + per_t * step : per_t + per_s * step;
      per[e] = by_s ? per_t : per_s;
    }
    // The normal must point down the ray at the lower end of the prism's interval, and up at the
    // upper end. A code does not store the sign of the depth component. So the code is negated if
    // that sign would be wrong.
    const auto facing = [&](int edge, bool at_hi) {
      if (edge >= 0 && !side_code[edge]) side_code[edge] = code_of(face.side[edge], axis);
      const uint32_t code = edge < 0 ? code_of_face() : *side_code[edge];
      const double along = edge < 0 ? normal[di] : face.side[edge][di];
      return (along > 0) == at_hi || along == 0 ? code : negate_normal(code);
    };
    const SweptShadow shadow(corner, motion_, ui, vi);
    for (int v = 0; v <= v1 - v0; v++) {
      int first = u0, last = u1;
      if (last > first) shadow.narrow(v0 + v, first, last);
      for (int u = first - u0; u <= last - u0; u++) {
        const double gamma = across.at(u, v);
        const double other0 = by_s ? -gamma / alpha : -gamma / beta;
        double lo = by_s ? 0 : -1e30, hi = by_s ? 1 : 1e30;
        if (!by_s) {
          clip(step, other0, lo, hi);
          clip(-step, 1 - other0, lo, hi);
        }
        int edge_lo = -1, edge_hi = -1;
        for (int e = 0; e < 3 && lo <= hi; e++) {
          const double lo_before = lo, hi_before = hi;
          clip(slope[e], edge_across[e].at(u, v) + other0 * per[e], lo, hi);
          if (lo != lo_before) edge_lo = e;
          if (hi != hi_before) edge_hi = e;
        }
        if (!(lo <= hi)) continue;
        const double t0 = by_s ? other0 + step * lo : lo, t1 = by_s ? other0 + step * hi : hi;
        const auto slot = static_cast<size_t>((v0 + v - rays.v0) * kTileSide + u0 + u - rays.u0);
        if (t0 <= t1)
          all[slot].push_back({static_cast<float>(t0), static_cast<float>(t1),
                               facing(edge_lo, false), facing(edge_hi, true)});
        else
          all[slot].push_back({static_cast<float>(t1), static_cast<float>(t0),
                               facing(edge_hi, false), facing(edge_lo, true)});
      }
    }
  }
  for (size_t slot = 0; slot < kTileRays; slot++) {
    auto& crossings = crossings_of[slot];
    auto& list = all[slot];
    std::sort(crossings.begin(), crossings.end());
    int winding = 0;
    for (size_t i = 0; i < crossings.size(); i++) {
      const int before = winding;
      winding += crossings[i].sign;
      if (before == 0)
        list.push_back({crossings[i].depth, crossings[i].depth, crossings[i].code, 0});
      if (winding == 0 && before != 0) {
        list.back().hi = crossings[i].depth;
        list.back().normal_hi = crossings[i].code;
      }
    }
    std::sort(list.begin(), list.end(), [](const Interval& a, const Interval& b) {
      return a.lo != b.lo ? a.lo < b.lo : a.hi < b.hi;
    });
    size_t kept = 0;
    for (const Interval& next : list) {
      if (kept > 0 && next.lo <= list[kept - 1].hi + kSeam) {
        if (next.hi > list[kept - 1].hi) {
          list[kept - 1].hi = next.hi;
          list[kept - 1].normal_hi = next.normal_hi;
        }
      } else {
        list[kept++] = next;
      }
    }
    list.resize(kept);
    std::erase_if(list, [](const Interval& i) { return !(i.lo < i.hi); });
  }
}

}  // namespace kibori
