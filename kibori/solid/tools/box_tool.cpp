// SPDX-License-Identifier: MIT
#include <kibori/solid/tools/box_tool.h>

namespace kibori {

void BoxTool::add_parts(SweptParts& parts) const {
  const Vec3 s = size * parts.scale();
  ConvexBody body;
  for (int i = 0; i < 2; i++) {
    body.add_plane(Vec3::Unit(i), s[i] / 2);
    body.add_plane(-Vec3::Unit(i), s[i] / 2);
  }
  body.add_plane(Vec3(0, 0, 1), 0);
  body.add_plane(Vec3(0, 0, -1), s.z());
  body.local_bounds = {Vec3(-s.x() / 2, -s.y() / 2, 0), Vec3(s.x() / 2, s.y() / 2, s.z())};
  parts.convex(body);
}

}  // namespace kibori
