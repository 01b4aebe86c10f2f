// SPDX-License-Identifier: MIT
// The swept rounded rim of a bull-nose cutter. A disc moves along a straight line. The solid is the
// set of points that are below the disc and within `corner` of it. The tool's shank contains the
// points above the disc.
//
// The distance G(t, s) from a ray's point t to the disc at motion parameter s is convex. Therefore,
// each end of the interval is a root of a convex function of t: H(t) = min over s of G(t, s) =
// corner. Newton's method starts at the end of the enclosing swept ball. It first finds the end of
// the rim at one pose, usually the first or the last one. If the motion is short, this is the
// result for almost every ray. For the other rays, it refines s by a few steps after each step of
// t. The number of steps is limited.
#pragma once

#include <kibori/solid/ball.h>
#include <kibori/solid/solid.h>

namespace kibori {

class SweptRim final : public Solid {
 public:
  // Centre of the disc at the start, its frame (z: its axis), radii of disc and corner [lattice
  // units], motion. start_is_clear: the start pose holds no material, so `spans` may omit rays on
  // which the sweep reaches nothing beyond it.
  SweptRim(const LatticePoint& centre, const Mat3& frame, double disc_radius, double corner,
           const LatticeVector& motion, bool start_is_clear = false);

  LatticeBox bounds() const override { return bounds_; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

  struct View {
    float u_base, v_base, depth;  // of ray (0, 0) relative to the disc's centre; the centre's depth
    float mu, mv, mt, nu, nv, nt;
    float disc_radius, corner, s_min, s_max;
    float low, high;  // range of the rim's heights above the disc at s = 0
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
