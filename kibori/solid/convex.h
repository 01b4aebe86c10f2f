// SPDX-License-Identifier: MIT
// A convex solid {q >= 0} with {l_j >= 0}, swept along a straight line. It has one quadric and up
// to six half-spaces. The finger, flat cutter, cone, ellipsoid, box and half-space are such solids.
// The result is exact: one interval per ray.
//
// Let the body be at motion parameter s, from 0 to 1. Depth t along the ray is in the body if
// q(t, s) >= 0 and all l_j(t, s) >= 0. In the (t, s) plane, these points are a convex region. The
// sweep's interval is its projection on the t axis. An end of the projection is
//   - on s = 0 or s = 1 (the end poses),                      s
//   - on a line l_j = 0 (the swept rim of a cap), or        1 ┼──╭────╮──  <- end pose
//   - where q = 0 has a vertical tangent (silhouette).        │ ╭╯    │
// Each is one quadratic. Those inside the region are        0 ┼─╰─────╯──  <- start pose
// candidates, and the interval is their hull.                 └──────────► t
// A cone's silhouettes are two planes. Rounding never makes them one plane.
#pragma once

#include <array>

#include <kibori/solid/solid.h>

namespace kibori {

// The body before the sweep, in the tool frame [lattice units].
struct ConvexBody {
  static constexpr int kMaxPlanes = 6;

  // q(x) = x'Qx + 2b'x + c and l_j(x) = n_j'x + c_j, tool frame, lattice units.
  Mat3 q = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  double c = 1;  // q(x) = 1: no quadric
  int planes = 0;
  std::array<Vec3, kMaxPlanes> plane_normal;
  std::array<double, kMaxPlanes> plane_offset;
  // True for a circular cone with its apex at the origin. Its q is not concave. q >= 0 is a double
  // cone; plane 0, perpendicular to the axis, selects one of its halves. If plane 0 is through the
  // apex, it has no face. If it is above the apex, it is the lower face of a frustum.
  bool cone = false;
  // A box [lattice units, tool frame] that holds the body; infinite if the body is.
  Box local_bounds;
  // For a rod along the axis: its thickness and the height of its top [lattice units]. Far above
  // the tip, coordinates are relative to a point of the axis near the tile (kSlender). With a
  // thickness of 0, the body is not a rod.
  double rod_thickness = 0, rod_top = 0;

  void add_plane(const Vec3& normal, double offset);
  // The same body, larger by `factor`.
  ConvexBody scaled(double factor) const;
};

class SweptConvex final : public Solid {
 public:
  // `tip` and `frame` are the pose at the start. start_is_clear: the start pose holds no material,
  // so `spans` may omit rays on which the sweep reaches nothing beyond it.
  SweptConvex(const ConvexBody& body, const LatticePoint& tip, const Mat3& frame,
              const LatticeVector& motion, bool start_is_clear = false);

  LatticeBox bounds() const override { return {bounds_}; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

  // The sweep in one field's coordinates (u, v, t), relative to the tip at the start.
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
    // A cone's silhouettes: planes through the tip, as outward normals and as t(u, v).
    struct Tangent {
      float nu, nv, nt, t_by_u, t_by_v;
    } tangents[2];
  };

 private:
  View view_at(const RayTile& rays) const;
  bool only_behind(const RayTile& rays) const;

  Vec3 motion_;
  Box bounds_;
  bool recentre_;  // recentre along the motion, tile by tile
  // True for a rod so long that some tiles need an origin farther along its axis.
  bool is_rod_ = false;
  Vec3 axis_;
  double rod_top_ = 0, rod_near_ = 0;  // height of its top; up to rod_near_, the tip is the origin
  // If set, points can enter the sweep only through the quadric, and only where `ahead_`(x -
  // tip) + ahead_offset_ > 0.
  bool only_ahead_ = false;
  Vec3 tip_, ahead_;
  double ahead_offset_ = 0;
  std::array<View, 3> views_;
  // The data of the views in double precision, for views with another origin.
  Mat3 q_;
  Vec3 b_;
  double c_;
  std::array<Vec3, ConvexBody::kMaxPlanes> plane_normal_;
  std::array<double, ConvexBody::kMaxPlanes> plane_offset_;
};

}  // namespace kibori
