// SPDX-License-Identifier: MIT
#include <kibori/solid/mesh_solid.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <kibori/dexel/normal_code.h>
#include <kibori/solid/crossings.h>

namespace kibori {
namespace {

// Neighbouring prisms meet to rounding; a gap this thin [lattice units] between two of them is no
// gap.
constexpr float kSeam = 1e-3f;
// A triangle whose prism a ray sees edge-on, sine below this, has no interval of its own there: its
// neighbours have it. Larger, and thin slits open; smaller, and the interval is rounding.
constexpr double kEdgeOn = 1e-12;
// Fewer triangles are not sorted into tiles.
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

}  // namespace

SweptMesh::SweptMesh(std::shared_ptr<const TriangleMesh> mesh, const Pose& start,
                     const LatticeVector& motion, const Lattice& lattice)
    : mesh_(std::move(mesh)), motion_(motion.units) {
  points_.reserve(mesh_->vertices.size());
  for (const Vec3& p : mesh_->vertices) {
    points_.push_back(lattice.to_lattice(start.to_world(p)).units);
    bounds_.include(points_.back());
    bounds_.include(Vec3(points_.back() + motion_));
  }
  if (mesh_->triangles.size() < kWorthBins) return;
  for (const Axis axis : kAxes) sort_into(bins_[static_cast<size_t>(axis)], axis, lattice);
}

std::array<double, 4> SweptMesh::swept_rect(uint32_t triangle, Axis axis) const {
  const auto& corners = mesh_->triangles[triangle];
  const Vec3 &a = points_[corners[0]], &b = points_[corners[1]], &c = points_[corners[2]];
  const int ui = u_index(axis), vi = v_index(axis);
  const auto [u_lo, u_hi] = std::minmax({a[ui], b[ui], c[ui]});
  const auto [v_lo, v_hi] = std::minmax({a[vi], b[vi], c[vi]});
  return {u_lo + std::min(motion_[ui], 0.0), u_hi + std::max(motion_[ui], 0.0),
          v_lo + std::min(motion_[vi], 0.0), v_hi + std::max(motion_[vi], 0.0)};
}

void SweptMesh::sort_into(Bins& bins, Axis axis, const Lattice& lattice) const {
  const auto tile_of = [](double at, int nodes) {
    return static_cast<int>(std::floor(std::clamp(at, 0.0, nodes - 1.0) / kTileSide));
  };
  const int ui = u_index(axis), vi = v_index(axis);
  bins.u = tile_of(bounds_.min[ui] - 1, lattice.nodes[ui]);
  bins.v = tile_of(bounds_.min[vi] - 1, lattice.nodes[vi]);
  bins.across = tile_of(bounds_.max[ui] + 1, lattice.nodes[ui]) - bins.u + 1;
  bins.down = tile_of(bounds_.max[vi] + 1, lattice.nodes[vi]) - bins.v + 1;
  // Counted, then put in their places; a triangle that touches two tiles is of both.
  const auto for_bins = [&](auto&& f) {
    for (uint32_t i = 0; i < mesh_->triangles.size(); i++) {
      const auto [u_lo, u_hi, v_lo, v_hi] = swept_rect(i, axis);
      const int tu0 = tile_of(u_lo - 1, lattice.nodes[ui]),
                tu1 = tile_of(u_hi + 1, lattice.nodes[ui]),
                tv0 = tile_of(v_lo - 1, lattice.nodes[vi]),
                tv1 = tile_of(v_hi + 1, lattice.nodes[vi]);
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
  const int tile_u = rays.u0 / kTileSide - bins.u, tile_v = rays.v0 / kTileSide - bins.v;
  // A tile that no bin is for is asked about by all triangles.
  const bool binned = rays.u0 % kTileSide == 0 && rays.v0 % kTileSide == 0 && tile_u >= 0 &&
                      tile_v >= 0 && tile_u < bins.across && tile_v < bins.down;
  const size_t bin = binned ? static_cast<size_t>(tile_v * bins.across + tile_u) : 0,
               begins = binned ? bins.first[bin] : 0,
               ends = binned ? bins.first[bin + 1] : mesh_->triangles.size();

  const Axis axis = rays.axis;
  const int ui = u_index(axis), vi = v_index(axis), di = depth_index(axis);
  const RayRect rect{rays.u0, rays.u0 + kTileSide, rays.v0, rays.v0 + kTileSide};
  const bool moving = motion_.squaredNorm() > kNoSweep * kNoSweep;
  for (size_t i = begins; i < ends; i++) {
    const auto number = binned ? bins.triangles[i] : static_cast<uint32_t>(i);
    const auto& triangle = mesh_->triangles[number];
    const Vec3 &a = points_[triangle[0]], &b = points_[triangle[1]], &c = points_[triangle[2]];
    const auto [u_lo, u_hi, v_lo, v_hi] = swept_rect(number, axis);
    if (u_hi < rect.u0 || u_lo > rect.u1 || v_hi < rect.v0 || v_lo > rect.v1) continue;
    const Vec3 normal = (b - a).cross(c - a);
    const uint32_t face_code = code_of(normal, axis);
    for_crossings(snap({a}, axis), snap({b}, axis), snap({c}, axis), axis, rect,
                  [&](int u, int v, double depth, int sign) {
                    const auto slot =
                        static_cast<size_t>((v - rays.v0) * kTileSide + (u - rays.u0));
                    // The depth on the unsnapped plane, where the prism of this triangle begins.
                    Vec3 o = Vec3::Zero();
                    o[ui] = u + 0.5;
                    o[vi] = v + 0.5;
                    const auto [low, high] = std::minmax({a[di], b[di], c[di]});
                    const double exact = normal.dot(a - o) / normal[di];
                    depth = std::isfinite(exact) ? std::clamp(exact, low, high) : depth;
                    crossings_of[slot].push_back({static_cast<float>(depth), sign, face_code});
                  });
    if (!moving) continue;
    // The prism: over the (t, s) plane of a ray, the triangle is a line (its plane) clipped by
    // three edges and 0 <= s <= 1; the prism's interval is the shadow of that segment on t.
    const double alpha = normal[di], beta = -normal.dot(motion_);
    if (std::abs(alpha) + std::abs(beta) < kEdgeOn * normal.norm()) continue;
    const bool by_s = std::abs(alpha) >= std::abs(beta);
    const Vec3 edge_normal[3] = {normal.cross(b - a), normal.cross(c - b), normal.cross(a - c)};
    const Vec3* corner[3] = {&a, &b, &c};
    // Silhouette normals of the prism's sides, per edge.
    Vec3 side[3] = {(b - a).cross(motion_), (c - b).cross(motion_), (a - c).cross(motion_)};
    for (int e = 0; e < 3; e++)
      if (side[e].dot(*corner[(e + 2) % 3] - *corner[e]) > 0) side[e] = -side[e];
    const int u0 = std::max(rect.u0, static_cast<int>(std::floor(u_lo - 0.5)));
    const int u1 = std::min(rect.u1 - 1, static_cast<int>(std::ceil(u_hi - 0.5)));
    const int v0 = std::max(rect.v0, static_cast<int>(std::floor(v_lo - 0.5)));
    const int v1 = std::min(rect.v1 - 1, static_cast<int>(std::ceil(v_hi - 0.5)));
    for (int v = v0; v <= v1; v++)
      for (int u = u0; u <= u1; u++) {
        Vec3 o = Vec3::Zero();
        o[ui] = u + 0.5;
        o[vi] = v + 0.5;
        const double gamma = normal.dot(o - a);
        const double other0 = by_s ? -gamma / alpha : -gamma / beta,
                     step = by_s ? -beta / alpha : -alpha / beta;
        double lo = by_s ? 0 : -1e30, hi = by_s ? 1 : 1e30;
        if (!by_s) {
          clip(step, other0, lo, hi);
          clip(-step, 1 - other0, lo, hi);
        }
        int edge_lo = -1, edge_hi = -1;
        for (int e = 0; e < 3; e++) {
          const double per_t = edge_normal[e][di], per_s = -edge_normal[e].dot(motion_);
          const double base = edge_normal[e].dot(o - *corner[e]);
          const double slope = by_s ? per_s + per_t * step : per_t + per_s * step;
          const double lo_before = lo, hi_before = hi;
          clip(slope, base + other0 * (by_s ? per_t : per_s), lo, hi);
          if (lo != lo_before) edge_lo = e;
          if (hi != hi_before) edge_hi = e;
        }
        if (!(lo <= hi)) continue;
        const double t0 = by_s ? other0 + step * lo : lo, t1 = by_s ? other0 + step * hi : hi;
        const uint32_t code0 = code_of(edge_lo < 0 ? normal : side[edge_lo], axis);
        const uint32_t code1 = code_of(edge_hi < 0 ? normal : side[edge_hi], axis);
        const bool forward = t0 <= t1;
        // The tri's own face normal turns with the side of the prism it closes: codes carry no
        // depth sign, so flip where the component along the ray would come out wrong.
        const auto facing = [&](const Vec3& n, uint32_t code, bool at_hi) {
          return (n[di] > 0) == at_hi || n[di] == 0 ? code : negate_normal(code);
        };
        const Vec3& n0 = edge_lo < 0 ? normal : side[edge_lo];
        const Vec3& n1 = edge_hi < 0 ? normal : side[edge_hi];
        const auto slot = static_cast<size_t>((v - rays.v0) * kTileSide + (u - rays.u0));
        if (forward)
          all[slot].push_back({static_cast<float>(t0), static_cast<float>(t1),
                               facing(n0, code0, false), facing(n1, code1, true)});
        else
          all[slot].push_back({static_cast<float>(t1), static_cast<float>(t0),
                               facing(n1, code1, false), facing(n0, code0, true)});
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
