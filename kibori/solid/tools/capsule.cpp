// SPDX-License-Identifier: MIT
#include <kibori/solid/tools/capsule.h>

namespace kibori {
namespace {

// A motion along the axis sweeps no parallelogram. An area below this [lattice units^2] is rounding
// error, and its normal has no direction.
constexpr double kNoArea = 1e-9;

// The parallelogram of a and b, thickened by `round` on both sides of its plane.
ConvexBody slab(const Vec3& a, const Vec3& b, double round) {
  ConvexBody body;
  const Vec3 normal = a.cross(b).normalized();
  body.add_plane(normal, round);
  body.add_plane(-normal, round);
  const Vec3 across_a = normal.cross(a).normalized(), across_b = b.cross(normal).normalized();
  body.add_plane(across_a, 0);
  body.add_plane(-across_a, across_a.dot(b));
  body.add_plane(across_b, 0);
  body.add_plane(-across_b, across_b.dot(a));
  for (const Vec3& p : {Vec3(Vec3::Zero()), a, b, Vec3(a + b)}) body.local_bounds.include(p);
  body.local_bounds = body.local_bounds.grown(round);
  return body;
}

}  // namespace

void Capsule::add_parts(SweptParts& parts) const {
  const double round = radius * parts.scale();
  const LatticePoint base = parts.above_tip(round);
  const LatticeVector along{(length * parts.scale() - 2 * round) * parts.axis()};
  const LatticeVector& motion = parts.motion();
  parts.add<SweptBall>(base, motion, round);
  parts.add<SweptBall>(base + along, motion, round);
  parts.add<SweptBall>(base, along, round);
  parts.add<SweptBall>(base + motion, along, round);
  if (motion.units.cross(along.units).squaredNorm() > kNoArea * kNoArea)
    parts.add<SweptConvex>(slab(along.units, motion.units, round), base, Mat3::Identity(),
                           LatticeVector());
}

}  // namespace kibori
