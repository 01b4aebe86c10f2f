// SPDX-License-Identifier: MIT
#include <kibori/solid/tools/skew.h>

namespace kibori {
namespace {

SinCos slope_of(const Skew& skew) { return sin_cos(skew.skew_deg * (std::numbers::pi / 180)); }

// Height of the bevels at the end of the edge.
double bevels_mm(const Skew& skew) {
  const SinCos slope = slope_of(skew), half = half_angle(skew.bevel_deg);
  return skew.width * slope.sin / slope.cos + skew.thickness / 2 * half.cos / half.sin / slope.cos;
}

}  // namespace

void Skew::check(ToolCheck& checks) const {
  checks.between("bevel_deg", bevel_deg, 5, 120);
  checks.require(skew_deg <= 75, "skew_deg must not exceed 75");
  checks.require(length >= bevels_mm(*this),
                 "length must be at least the height of the bevels; raise length, or lower width");
}

// Two parts: the bevels, up to where their distance is the thickness, and the blade above.
void Skew::add_parts(SweptParts& parts) const {
  const double scale = parts.scale(), half_x = thickness * scale / 2, y = width * scale,
               z = length * scale;
  const SinCos slope = slope_of(*this), half = half_angle(bevel_deg);
  const Vec3 up(0, -slope.sin, slope.cos);  // perpendicular to the edge, in the blade's plane
  const double deep = half_x * half.cos / half.sin;
  ConvexBody bevels, blade;
  for (ConvexBody* part : {&bevels, &blade}) {
    part->add_plane(Vec3::UnitY(), 0);
    part->add_plane(-Vec3::UnitY(), y);
    part->local_bounds = {Vec3(-half_x, 0, 0), Vec3(half_x, y, z)};
  }
  for (const double side : {1.0, -1.0}) {
    bevels.add_plane(half.sin * up + Vec3(side * half.cos, 0, 0), 0);
    blade.add_plane(Vec3(side, 0, 0), half_x);
  }
  bevels.add_plane(-up, deep);
  blade.add_plane(up, -deep);
  blade.add_plane(-Vec3::UnitZ(), z);
  parts.convex(bevels);
  parts.convex(blade);
}

}  // namespace kibori
