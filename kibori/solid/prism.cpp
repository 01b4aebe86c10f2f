// SPDX-License-Identifier: MIT
#include <kibori/solid/prism.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

using Vec2 = Eigen::Vector2d;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

// A ray in the plane: from + t along. `across` is constant along it.
struct FlatRay {
  Vec2 from, along;
  double across() const { return cross(along, from); }
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// If the projection of a unit vector along the rays is shorter than this, each ray is one point
// in the plane.
constexpr double kAlong = 1e-9;

uint32_t code_of(const AcrossPlane& plane, const Vec2& normal, Axis axis) {
  const Vec3 n = normal.x() * plane.u + normal.y() * plane.v;
  return encode_normal(n[u_index(axis)], n[v_index(axis)], n[depth_index(axis)]);
}

// Position of a ray of the tile at depth 0. (du, dv) counts from the tile's corner.
Vec3 place_of(const RayTile& rays, double du, double dv) {
  Vec3 place = Vec3::Zero();
  place[u_index(rays.axis)] = rays.u0 + du;
  place[v_index(rays.axis)] = rays.v0 + dv;
  return place;
}

// The area of the plane that the rays of a tile cover.
struct Strip {
  Vec2 along;                                          // of a ray, per cell of depth
  double low, high;                                    // range across the rays
  double from_min = kInfinity, from_max = -kInfinity;  // range of a ray's depth 0 [cells along it]

  Strip(const AcrossPlane& plane, const RayTile& rays, const Vec2& along_) : along(along_) {
    low = kInfinity;
    high = -kInfinity;
    for (const double du : {0.0, 1.0})
      for (const double dv : {0.0, 1.0}) {
        const Vec2 at = plane.to_plane(place_of(rays, du * kTileSide, dv * kTileSide));
        const double w = cross(along, at), from = at.dot(along) / along.squaredNorm();
        low = std::min(low, w);
        high = std::max(high, w);
        from_min = std::min(from_min, from);
        from_max = std::max(from_max, from);
      }
  }
};

// The sides that come within `reach` of the rays of a strip, measured across the rays.
std::vector<const OutlineSide*> sides_near(const std::vector<OutlineSide>& sides,
                                           const Strip& strip, double reach) {
  const double slack = reach * strip.along.norm() + 1e-6;
  std::vector<const OutlineSide*> near;
  for (const OutlineSide& side : sides) {
    const auto [a, b] = std::minmax({cross(strip.along, side.a), cross(strip.along, side.b)});
    if (b >= strip.low - slack && a <= strip.high + slack) near.push_back(&side);
  }
  return near;
}

// The sides that come within `reach` of the tile's rays, which are points in the plane.
std::vector<OutlineSide> adjacent_sides(const std::vector<OutlineSide>& sides,
                                        const AcrossPlane& plane, const RayTile& rays,
                                        double reach) {
  std::vector<OutlineSide> near;
  for (const OutlineSide* side : sides_near(sides, Strip(plane, rays, Vec2::UnitX()), reach))
    near.push_back(*side);
  std::vector<OutlineSide> nearer;
  for (const OutlineSide* side : sides_near(near, Strip(plane, rays, Vec2::UnitY()), reach))
    nearer.push_back(*side);
  return nearer;
}

// Calls f(ray, its list in `all`) for the rays of a tile. If several rays have the same projection
// on the plane, their lists are equal, so it calls f once for all of them.
template <class All, class F>
void for_rays(const AcrossPlane& plane, const RayTile& rays, const Vec2& along, All& all, F&& f) {
  std::array<Vec2, kTileSide> by_lane, by_row;
  const int u = u_index(rays.axis), v = v_index(rays.axis);
  for (int i = 0; i < kTileSide; i++) {
    by_lane[static_cast<size_t>(i)] = (rays.u0 + i + 0.5) * Vec2(plane.u[u], plane.v[u]);
    by_row[static_cast<size_t>(i)] = (rays.v0 + i + 0.5) * Vec2(plane.u[v], plane.v[v]);
  }
  const bool lanes_are_one = by_lane.front() == by_lane.back(),
             rows_are_one = by_row.front() == by_row.back();
  for (size_t row = 0; row < kTileSide; row++)
    for (size_t lane = 0; lane < kTileSide; lane++) {
      const size_t slot = row * kTileSide + lane;
      if (rows_are_one && row > 0)
        all[slot] = all[lane];
      else if (lanes_are_one && lane > 0)
        all[slot] = all[slot - 1];
      else
        f(FlatRay{by_lane[lane] + by_row[row], along}, all[slot]);
    }
}

Vec2 along_of(const AcrossPlane& plane, Axis axis) {
  Vec3 direction = Vec3::Zero();
  direction[depth_index(axis)] = 1;
  return plane.to_plane(direction);
}

bool is_inside(const std::vector<OutlineSide>& sides, const Vec2& p) {
  bool inside = false;
  for (const OutlineSide& s : sides)
    if ((s.a.y() <= p.y()) != (s.b.y() <= p.y()) &&
        p.x() < s.a.x() + (p.y() - s.a.y()) / (s.b.y() - s.a.y()) * (s.b.x() - s.a.x()))
      inside = !inside;
  return inside;
}

}  // namespace

AcrossPlane::AcrossPlane(const Vec3& direction) {
  const Mat3 frame = frame_from_axis(direction);
  u = frame.col(0);
  v = frame.col(1);
}

LatticeBox SweptOutline::bounds() const {
  return {{Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity)}};
}

// ---- Prism

Prism::Prism(const AcrossPlane& plane, std::vector<OutlineSide> outline, const LatticeBox& within)
    : SweptOutline(plane, std::move(outline)), within_(within) {}

void Prism::fill(const RayTile& rays, TileIntervals& all) const {
  const Vec2 along = along_of(plane_, rays.axis);
  if (along.norm() < kAlong) {
    if (adjacent_sides(sides_, plane_, rays, 0).empty()) {
      // No side of the outline is near these rays, so all are inside or all are outside.
      const Vec3 middle = place_of(rays, kTileSide / 2.0, kTileSide / 2.0);
      if (is_inside(sides_, plane_.to_plane(middle)))
        for (auto& ray : all) ray.push_back({-kFar, kFar, 0, 0});
      return;
    }
    // The sides that a line along x from a ray of the tile can cross.
    std::vector<OutlineSide> near;
    for (const OutlineSide* side : sides_near(sides_, Strip(plane_, rays, Vec2::UnitX()), 0))
      near.push_back(*side);
    for_rays(plane_, rays, along, all, [&](const FlatRay& ray, auto& list) {
      if (is_inside(near, ray.from)) list.push_back({-kFar, kFar, 0, 0});
    });
    return;
  }
  struct Crossing {
    double t;
    uint32_t normal;
  };
  struct Side {
    const OutlineSide* side;
    double wa, wb;  // across the rays
    bool straight;
    uint32_t code;
  };
  const double per = 1 / along.squaredNorm();
  const Strip strip(plane_, rays, along);
  const double first = within_.units.min[depth_index(rays.axis)] - 1,
               last = within_.units.max[depth_index(rays.axis)] + 1;
  // The sides that rays cross in the box, and those that they cross before it. Sides behind the box
  // do not matter.
  std::vector<Side> here, before;
  for (const OutlineSide* side : sides_near(sides_, strip, 0)) {
    const double wa = cross(along, side->a), wb = cross(along, side->b);
    if (wa == wb) continue;
    const auto depth = [&](double w) {
      const double share = std::clamp((w - wa) / (wb - wa), 0.0, 1.0);
      return (side->a + share * (side->b - side->a)).dot(along) * per;
    };
    const auto [a, b] = std::minmax({depth(strip.low), depth(strip.high)});
    if (a - strip.from_max > last) continue;
    (b - strip.from_min < first ? before : here)
        .push_back({side, wa, wb, side->normal_a == side->normal_b,
                    code_of(plane_, side->normal_a, rays.axis)});
  }
  const auto crosses = [](const Side& side, double w) { return (side.wa <= w) != (side.wb <= w); };
  const auto is_in_at_first = [&](double w) {
    bool in = false;
    for (const Side& side : before) in ^= crosses(side, w);
    return in;
  };
  if (here.empty()) {
    // No ray meets the outline in the box, so all are inside there or all are outside.
    if (is_in_at_first((strip.low + strip.high) / 2))
      for (auto& ray : all) ray.push_back({-kFar, kFar, 0, 0});
    return;
  }
  std::vector<Crossing> crossings;
  for_rays(plane_, rays, along, all, [&](const FlatRay& ray, auto& list) {
    crossings.clear();
    const double w = ray.across();
    if (is_in_at_first(w)) crossings.push_back({-kFar, 0});
    for (const Side& s : here) {
      if (!crosses(s, w)) continue;
      const OutlineSide& side = *s.side;
      const double share = (w - s.wa) / (s.wb - s.wa);
      const Vec2 at = side.a + share * (side.b - side.a);
      crossings.push_back(
          {(at - ray.from).dot(along) * per,
           s.straight ? s.code
                      : code_of(plane_, side.normal_a + share * (side.normal_b - side.normal_a),
                                rays.axis)});
    }
    if (crossings.size() % 2 == 1) crossings.push_back({kFar, 0});
    if (crossings.size() > 2)
      std::sort(crossings.begin(), crossings.end(),
                [](const Crossing& x, const Crossing& y) { return x.t < y.t; });
    else if (crossings.size() == 2 && crossings[1].t < crossings[0].t)
      std::swap(crossings[0], crossings[1]);
    for (size_t i = 0; i < crossings.size(); i += 2) {
      const auto lo = static_cast<float>(crossings[i].t),
                 hi = static_cast<float>(crossings[i + 1].t);
      if (lo < hi) list.push_back({lo, hi, crossings[i].normal, crossings[i + 1].normal});
    }
  });
}

// ---- Wall

Wall::Wall(const AcrossPlane& plane, std::vector<OutlineSide> curve, double thickness)
    : SweptOutline(plane, std::move(curve)), half_(thickness / 2) {}

void Wall::fill(const RayTile& rays, TileIntervals& all) const {
  const Vec2 along = along_of(plane_, rays.axis);
  if (along.norm() < kAlong) {
    const std::vector<OutlineSide> near = adjacent_sides(sides_, plane_, rays, half_);
    if (near.empty()) return;
    for_rays(plane_, rays, along, all, [&](const FlatRay& ray, auto& list) {
      for (const OutlineSide& side : near) {
        const Vec2 d = side.b - side.a;
        const double s = std::clamp((ray.from - side.a).dot(d) / d.squaredNorm(), 0.0, 1.0);
        if ((ray.from - side.a - s * d).squaredNorm() > half_ * half_) continue;
        list.push_back({-kFar, kFar, 0, 0});
        break;
      }
    });
    return;
  }
  struct Part {
    double lo, hi;
    Vec2 normal_lo, normal_hi;
  };
  struct Side {
    const OutlineSide* side;
    Vec2 d, n;             // along the side, and to its right; unit
    double right, left;    // of its faces, along n and -n
    double after, before;  // of its ends, along d and -d
    bool ends_alone;       // no other side of `near` begins at its end
  };
  std::vector<Side> near;
  for (const OutlineSide* side : sides_near(sides_, Strip(plane_, rays, along), half_)) {
    const Vec2 d = (side->b - side->a).normalized(), n(d.y(), -d.x());
    if (!near.empty() && near.back().side->b == side->a) near.back().ends_alone = false;
    near.push_back({side, d, n, n.dot(side->a) + half_, half_ - n.dot(side->a), d.dot(side->b),
                    -d.dot(side->a), true});
  }
  if (near.empty()) return;
  const double per = 1 / along.squaredNorm();
  std::vector<Part> parts;
  // A disc at each corner, and a strip between two corners.
  const auto add_disc = [&](const FlatRay& ray, const Vec2& centre) {
    const double middle = (centre - ray.from).dot(along) * per;
    const Vec2 nearest = ray.from + middle * along - centre;
    const double left = half_ * half_ - nearest.squaredNorm();
    if (left <= 0) return;
    const double reach = std::sqrt(left * per);
    parts.push_back({middle - reach, middle + reach, (nearest - reach * along) / half_,
                     (nearest + reach * along) / half_});
  };
  const auto add_strip = [&](const FlatRay& ray, const Side& side) {
    Part part{-1e30, 1e30, side.n, side.n};
    // Keeps the part where normal . (from + t along) <= limit. If rays lie exactly in a face,
    // only one of the strip's two faces counts as inside.
    const auto clip = [&](const Vec2& normal, double limit, bool closed) {
      const double slope = normal.dot(along), rest = limit - normal.dot(ray.from);
      if (slope > 0 && rest / slope < part.hi) {
        part.hi = rest / slope;
        part.normal_hi = normal;
      } else if (slope < 0 && rest / slope > part.lo) {
        part.lo = rest / slope;
        part.normal_lo = normal;
      } else if (slope == 0 && (closed ? rest < 0 : rest <= 0)) {
        part.hi = -1e30;
      }
    };
    clip(side.n, side.right, true);
    clip(-side.n, side.left, false);
    clip(side.d, side.after, true);
    clip(-side.d, side.before, true);
    if (part.lo < part.hi) parts.push_back(part);
  };
  for_rays(plane_, rays, along, all, [&](const FlatRay& ray, auto& list) {
    parts.clear();
    for (const Side& side : near) {
      add_disc(ray, side.side->a);
      if (side.ends_alone) add_disc(ray, side.side->b);
      add_strip(ray, side);
    }
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
      return a.lo != b.lo ? a.lo < b.lo : a.hi > b.hi;
    });
    for (size_t i = 0; i < parts.size();) {
      Part whole = parts[i];
      for (i++; i < parts.size() && parts[i].lo <= whole.hi; i++)
        if (parts[i].hi > whole.hi) {
          whole.hi = parts[i].hi;
          whole.normal_hi = parts[i].normal_hi;
        }
      const auto lo = static_cast<float>(whole.lo), hi = static_cast<float>(whole.hi);
      if (lo < hi)
        list.push_back({lo, hi, code_of(plane_, whole.normal_lo, rays.axis),
                        code_of(plane_, whole.normal_hi, rays.axis)});
    }
  });
}

}  // namespace kibori
