// SPDX-License-Identifier: MIT
// The rounded rim of a bull-nose cutter, swept along a straight line. At one pose, the rim is the
// set of points that are below a disc and within `corner` of the disc. The tool's shank contains
// the points above the disc.
//
// Let G(t, s) be the distance from a ray's point t to the disc at s, the position in the motion (0
// to 1). G is convex. Let H(t) be the minimum of G(t, s) over all s. H is convex, too. The ends of
// the interval are the roots of H(t) = corner. Newton's method starts at the end of the enclosing
// swept ball. It first finds the end of the rim at one pose, usually the first or the last one. If
// the motion is short, this is the result for almost every ray. For the other rays, each step of t
// is followed by a few steps that refine s. The number of steps is limited.
#pragma once

#include <kibori/solid/ball.h>
#include <kibori/solid/solid.h>

namespace kibori {

class SweptRim final : public Solid {
 public:
  // `centre` is the disc's centre at the start. The third column of `frame` is the disc's axis. The
  // radii of disc and corner are in lattice units. With `start_is_clear`, the caller promises that
  // there is no material inside the rim at the start pose. `spans` may then omit rays on which the
  // sweep reaches nothing outside of the rim at that pose.
  SweptRim(const LatticePoint& centre, const Mat3& frame, double disc_radius, double corner,
           const LatticeVector& motion, bool start_is_clear = false);

  LatticeBox bounds() const override { return bounds_; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

  struct View {
    float u_base, v_base, depth;  // from the disc's centre to ray (0, 0); the centre's depth
    float mu, mv, mt, nu, nv, nt;
    float disc_radius, corner, s_min, s_max;
    float low, high;  // range of heights that the rim reaches, above the disc at s = 0
  };

 private:
  View view_at(const RayTile& rays) const;
  bool only_behind(const RayTile& rays) const;

  Vec3 centre_, axis_, motion_;
  double disc_radius_, corner_;
  bool start_is_clear_;
  SweptBall hull_;  // sweep of the smallest ball that holds the rim
  LatticeBox bounds_;
};

}  // namespace kibori
