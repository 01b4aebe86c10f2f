// SPDX-License-Identifier: MIT
#include <kibori/solid/tools/finger.h>

namespace kibori {

void Finger::add_parts(SweptParts& parts) const {
  const BodyTop top = parts.top(length);
  const double ks_units = ks * parts.pitch_mm(), half_wide = std::sqrt(top.height / ks_units);
  ConvexBody body;
  body.q.diagonal() << -ks_units, -ks_units, 0;
  body.b = Vec3(0, 0, 0.5);
  body.c = 0;
  top.close(body);
  body.local_bounds = {Vec3(-half_wide, -half_wide, 0), Vec3(half_wide, half_wide, top.height)};
  parts.convex(body);
}

}  // namespace kibori
