// SPDX-License-Identifier: MIT
#include <kibori/solid/tools/knife.h>

namespace kibori {

void Knife::add_parts(SweptParts& parts) const {
  const SinCos edge = half_angle(edge_deg), point = half_angle(point_deg);
  const BodyTop top = parts.top(length);
  ConvexBody body;
  for (const double x : {1.0, -1.0})
    for (const double y : {1.0, -1.0}) {
      // A side of the edge: up * sin - side * cos >= 0, with the half angle of the edge. `up` is
      // the direction in the blade that is perpendicular to the edge.
      const Vec3 up(-x * point.cos, 0, point.sin);
      body.add_plane(edge.sin * up - y * edge.cos * Vec3::UnitY(), 0);
    }
  top.close(body);
  const double half_x = top.height * point.sin / point.cos,
               half_y = top.height * point.sin * edge.sin / edge.cos;
  body.local_bounds = {Vec3(-half_x, -half_y, 0), Vec3(half_x, half_y, top.height)};
  parts.convex(body);
}

}  // namespace kibori
