// SPDX-License-Identifier: MIT
#include <kibori/solid/prism.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

using Vec2 = Eigen::Vector2d;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

// A ray in the plane: from + t along. `across` is the same all along it.
struct FlatRay {
  Vec2 from, along;
  double across() const { return cross(along, from); }
};

// A ray that runs along the direction to this much is one point in the plane.
constexpr double kAlong = 1e-9;

uint32_t code_of(const AcrossPlane& plane, const Vec2& normal, Axis axis) {
  const Vec3 n = normal.x() * plane.u + normal.y() * plane.v;
  return encode_normal(n[u_index(axis)], n[v_index(axis)], n[depth_index(axis)]);
}

// Which sides the rays of a tile can come within `reach` of: by what is across them.
std::vector<const OutlineSide*> sides_near(const std::vector<OutlineSide>& sides,
                                           const AcrossPlane& plane, const RayTile& rays,
                                           const Vec2& along, double reach) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double du : {0.0, 1.0})
    for (const double dv : {0.0, 1.0}) {
      Vec3 corner = Vec3::Zero();
      corner[u_index(rays.axis)] = rays.u0 + du * kTileSide;
      corner[v_index(rays.axis)] = rays.v0 + dv * kTileSide;
      const double w = cross(along, plane.to_plane(corner));
      low = std::min(low, w);
      high = std::max(high, w);
    }
  const double slack = reach * along.norm() + 1e-6;
  std::vector<const OutlineSide*> near;
  for (const OutlineSide& side : sides) {
    const auto [a, b] = std::minmax({cross(along, side.a), cross(along, side.b)});
    if (b >= low - slack && a <= high + slack) near.push_back(&side);
  }
  return near;
}

template <class F>
void for_rays(const AcrossPlane& plane, const RayTile& rays, F&& f) {
  Vec3 direction = Vec3::Zero();
  direction[depth_index(rays.axis)] = 1;
  const Vec2 along = plane.to_plane(direction);
  for (int row = 0; row < kTileSide; row++)
    for (int lane = 0; lane < kTileSide; lane++) {
      Vec3 o = Vec3::Zero();
      o[u_index(rays.axis)] = rays.u0 + lane + 0.5;
      o[v_index(rays.axis)] = rays.v0 + row + 0.5;
      f(static_cast<size_t>(row * kTileSide + lane), FlatRay{plane.to_plane(o), along});
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
  constexpr double inf = std::numeric_limits<double>::infinity();
  return {{Vec3::Constant(-inf), Vec3::Constant(inf)}};
}

// ---- Prism

Prism::Prism(const AcrossPlane& plane, std::vector<OutlineSide> outline)
    : SweptOutline(plane, std::move(outline)) {}

void Prism::fill(const RayTile& rays, TileIntervals& all) const {
  const Vec2 along = along_of(plane_, rays.axis);
  if (along.norm() < kAlong) {
    // Which sides a line along x from a ray of the tile can cross.
    std::vector<OutlineSide> near;
    for (const OutlineSide* side : sides_near(sides_, plane_, rays, Vec2::UnitX(), 0))
      near.push_back(*side);
    for_rays(plane_, rays, [&](size_t slot, const FlatRay& ray) {
      if (is_inside(near, ray.from)) all[slot].push_back({-kFar, kFar, 0, 0});
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
  std::vector<Side> near;
  for (const OutlineSide* side : sides_near(sides_, plane_, rays, along, 0))
    near.push_back({side, cross(along, side->a), cross(along, side->b),
                    side->normal_a == side->normal_b, code_of(plane_, side->normal_a, rays.axis)});
  std::vector<Crossing> crossings;
  const double per = 1 / along.squaredNorm();
  for_rays(plane_, rays, [&](size_t slot, const FlatRay& ray) {
    crossings.clear();
    const double w = ray.across();
    for (const auto& [side, wa, wb, straight, code] : near) {
      if ((wa <= w) == (wb <= w)) continue;
      const double share = (w - wa) / (wb - wa);
      const Vec2 at = side->a + share * (side->b - side->a);
      crossings.push_back(
          {(at - ray.from).dot(along) * per,
           straight ? code
                    : code_of(plane_, side->normal_a + share * (side->normal_b - side->normal_a),
                              rays.axis)});
    }
    if (crossings.size() > 2)
      std::sort(crossings.begin(), crossings.end(),
                [](const Crossing& x, const Crossing& y) { return x.t < y.t; });
    else if (crossings.size() == 2 && crossings[1].t < crossings[0].t)
      std::swap(crossings[0], crossings[1]);
    for (size_t i = 0; i + 1 < crossings.size(); i += 2) {
      const auto lo = static_cast<float>(crossings[i].t),
                 hi = static_cast<float>(crossings[i + 1].t);
      if (lo < hi) all[slot].push_back({lo, hi, crossings[i].normal, crossings[i + 1].normal});
    }
  });
}

// ---- Wall

Wall::Wall(const AcrossPlane& plane, std::vector<OutlineSide> curve, double thickness)
    : SweptOutline(plane, std::move(curve)), half_(thickness / 2) {}

void Wall::fill(const RayTile& rays, TileIntervals& all) const {
  const Vec2 along = along_of(plane_, rays.axis);
  if (along.norm() < kAlong) {
    for_rays(plane_, rays, [&](size_t slot, const FlatRay& ray) {
      for (const OutlineSide& side : sides_) {
        const Vec2 d = side.b - side.a;
        const double s = std::clamp((ray.from - side.a).dot(d) / d.squaredNorm(), 0.0, 1.0);
        if ((ray.from - side.a - s * d).squaredNorm() > half_ * half_) continue;
        all[slot].push_back({-kFar, kFar, 0, 0});
        break;
      }
    });
    return;
  }
  struct Part {
    double lo, hi;
    Vec2 normal_lo, normal_hi;
  };
  const auto near = sides_near(sides_, plane_, rays, along, half_);
  const double per = 1 / along.squaredNorm();
  std::vector<Part> parts;
  // A disc at each corner, and the strip between two.
  const auto add_disc = [&](const FlatRay& ray, const Vec2& centre) {
    const double middle = (centre - ray.from).dot(along) * per;
    const Vec2 nearest = ray.from + middle * along - centre;
    const double left = half_ * half_ - nearest.squaredNorm();
    if (left <= 0) return;
    const double reach = std::sqrt(left * per);
    parts.push_back({middle - reach, middle + reach, (nearest - reach * along) / half_,
                     (nearest + reach * along) / half_});
  };
  const auto add_strip = [&](const FlatRay& ray, const OutlineSide& side) {
    const Vec2 d = (side.b - side.a).normalized(), n(d.y(), -d.x());
    Part part{-1e30, 1e30, n, n};
    // Where normal . (from + t along) <= limit; of two faces that rays lie in, one is the strip's.
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
    clip(n, n.dot(side.a) + half_, true);
    clip(-n, half_ - n.dot(side.a), false);
    clip(d, d.dot(side.b), true);
    clip(-d, -d.dot(side.a), true);
    if (part.lo < part.hi) parts.push_back(part);
  };
  for_rays(plane_, rays, [&](size_t slot, const FlatRay& ray) {
    parts.clear();
    for (const OutlineSide* side : near) {
      add_disc(ray, side->a);
      add_disc(ray, side->b);
      add_strip(ray, *side);
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
        all[slot].push_back({lo, hi, code_of(plane_, whole.normal_lo, rays.axis),
                             code_of(plane_, whole.normal_hi, rays.axis)});
    }
  });
}

}  // namespace kibori
