// SPDX-License-Identifier: MIT
#include <kibori/solid/tools/ellipsoid.h>

namespace kibori {

void Ellipsoid::add_parts(SweptParts& parts) const {
  const Vec3 r = radii * parts.scale();
  ConvexBody body;
  body.q.diagonal() = -r.cwiseProduct(r).cwiseInverse() * r.z();
  // q = r_z (1 - |(x - centre)/r|^2), with the centre at height r_z. Along z, it is 2z - z^2/r_z.
  body.b = Vec3(0, 0, 1);
  body.c = 0;
  body.local_bounds = {Vec3(-r.x(), -r.y(), 0), Vec3(r.x(), r.y(), 2 * r.z())};
  body.rod_thickness = 2 * std::min(r.x(), r.y());
  body.rod_top = 2 * r.z();
  parts.convex(body);
}

}  // namespace kibori
