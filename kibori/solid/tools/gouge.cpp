// SPDX-License-Identifier: MIT
#include <kibori/solid/tools/gouge.h>

namespace kibori {

GougeArc gouge_arc(const Gouge& gouge) {
  // Radius of the arc divided by its width, for sweeps 2 to 8. The values are chosen so that the
  // steps between sweeps are similar. Carvers' lists (London pattern, Swiss) differ by up to one
  // sweep number.
  constexpr double kRadius[] = {2.5, 1.75, 1.25, 1, 0.75, 0.625, 0.55};  // 2 to 8
  // Depth divided by width.
  constexpr double kDepth[] = {0.5, 0.65, 0.85};  // 9 to 11
  const int sweep = static_cast<int>(gouge.sweep);
  if (sweep >= 9) {
    const double depth = kDepth[sweep - 9] * gouge.width;
    return {gouge.width / 2, depth, depth};
  }
  const double radius = kRadius[sweep - 2] * gouge.width;
  return {radius, radius, radius - std::sqrt(radius * radius - gouge.width * gouge.width / 4)};
}

void Gouge::add_parts(SweptParts& parts) const {
  const double scale = parts.scale(), half_x = thickness / 2 * scale, half_y = width / 2 * scale;
  const GougeArc arc = gouge_arc(*this);
  const double across = arc.across * scale, upright = arc.upright * scale;
  const BodyTop top = parts.top(std::min(arc.depth, length));
  ConvexBody body;
  body.q.diagonal() << 0, -upright / (across * across), -1 / upright;
  body.b = Vec3(0, 0, 1);
  body.c = 0;
  body.add_plane(Vec3(1, 0, 0), half_x);
  body.add_plane(Vec3(-1, 0, 0), half_x);
  top.close(body);
  body.local_bounds = {Vec3(-half_x, -half_y, 0), Vec3(half_x, half_y, top.height)};
  parts.convex(body);
  parts.upright_box(thickness, width, arc.depth, length);
}

}  // namespace kibori
