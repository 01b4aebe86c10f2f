// SPDX-License-Identifier: MIT
// A convex solid {q >= 0} with {l_j >= 0}, one quadric and up to six half-spaces, swept along a
// straight line: the finger, flat cutter, cone, ellipsoid, box and half-space are all of this kind.
// Exact, one interval per ray.
//
// Put the body at motion parameter s; depth t along the ray is in the sweep when some s in [0, 1]
// has q(t, s) >= 0 and all l_j(t, s) >= 0. In the (t, s) plane that is a convex region, and the
// sweep's interval is its shadow on the t axis. The shadow's ends lie
//   - on s = 0 or s = 1 (the end poses),                      s
//   - on a line l_j = 0 (the swept rim of a cap), or        1 ┼──╭────╮──  <- end pose
//   - where q = 0 has a vertical tangent (silhouette).        │ ╭╯    │
// Each is one quadratic; those inside the region are        0 ┼─╰─────╯──  <- start pose
// candidates, and the interval is their hull.                 └──────────► t
// A cone's silhouettes are two planes, which no rounding makes one.
#pragma once

#include <array>

#include <kibori/solid/solid.h>

namespace kibori {

struct ConvexBody {
  static constexpr int kMaxPlanes = 6;

  // q(x) = x'Qx + 2b'x + c and l_j(x) = n_j'x + c_j, tool frame, lattice units.
  Mat3 q = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  double c = 1;  // q = 1: no quadric at all
  int planes = 0;
  std::array<Vec3, kMaxPlanes> plane_normal;
  std::array<double, kMaxPlanes> plane_offset;
  // Set for a cone (circular, apex at the origin): q is not concave, and plane 0, square to its
  // axis, picks the nappe. Through the apex it has no face of its own; above the apex it is the
  // lower face of a frustum.
  bool cone = false;
  // A box [lattice units, tool frame] that holds the body; infinite where the body is.
  Box local_bounds;
  // Of a rod along the axis: how thick it is, and how high it goes [lattice units], whatever part
  // of it can meet material. Far up it is counted from beside each tile (kSlender). 0: it is none.
  double rod_thickness = 0, rod_top = 0;

  void add_plane(const Vec3& normal, double offset);
  // Same body, larger by `factor`.
  ConvexBody scaled(double factor) const;
};

class SweptConvex final : public Solid {
 public:
  // tip, frame: pose at the start. start_is_clear: there is no material in the start pose, so rays
  // on which the sweep reaches nothing beyond it may be left out.
  SweptConvex(const ConvexBody& body, const LatticePoint& tip, const Mat3& frame,
              const LatticeVector& motion, bool start_is_clear = false);

  LatticeBox bounds() const override { return {bounds_}; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

  // The sweep as one field sees it: coordinates (u, v, t) relative to the tip at the start.
  struct View {
    double tip_u, tip_v, tip_d;
    float quu, quv, qvv, qut, qvt, qtt;  // the quadric
    float bu, bv, bt, c;
    float mu, mv, mt;            // motion
    float qm_u, qm_v, qm_t, bm;  // Q motion, b'motion
    float tt, ts, ss;            // q(t, s) = tt t^2 + 2 ts t s + ss s^2 + ...
    float s_min, s_max;
    bool moving, quadric, cone;
    int planes, first_face;  // the plane through a cone's apex has no face
    float nu[ConvexBody::kMaxPlanes], nv[ConvexBody::kMaxPlanes], nt[ConvexBody::kMaxPlanes];
    float offset[ConvexBody::kMaxPlanes], slope[ConvexBody::kMaxPlanes];  // slope: d l_j / d s
    // A cone's silhouettes: planes through the tip, by their outward normals and as t(u, v).
    struct Tangent {
      float nu, nv, nt, t_by_u, t_by_v;
    } tangents[2];
  };

 private:
  View view_at(const RayTile& rays) const;
  bool only_behind(const RayTile& rays) const;

  Vec3 motion_;
  Box bounds_;
  bool recentre_;  // along the motion, tile by tile
  // Of a rod that may have to be re-centred along its axis.
  bool is_rod_ = false;
  Vec3 axis_;
  double rod_top_ = 0, rod_near_ = 0;  // where it goes; up to where the tip is near enough
  // Set where a point that the start pose does not hold can only be reached through the quadric, at
  // places where `ahead_`(x - tip) + ahead_offset_ > 0.
  bool only_ahead_ = false;
  Vec3 tip_, ahead_;
  double ahead_offset_ = 0;
  std::array<View, 3> views_;
  // Doubles behind the views, for re-centring.
  Mat3 q_;
  Vec3 b_;
  double c_;
  std::array<Vec3, ConvexBody::kMaxPlanes> plane_normal_;
  std::array<double, ConvexBody::kMaxPlanes> plane_offset_;
};

}  // namespace kibori
