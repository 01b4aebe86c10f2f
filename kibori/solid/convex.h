// SPDX-License-Identifier: MIT
// A convex solid swept along a straight line. The solid is the set of points where q >= 0 and all
// l_j >= 0. q is one quadratic function, and there are up to six linear functions l_j
// (half-spaces). The finger, flat cutter, cone, ellipsoid, box and half-space are such solids. The
// result is exact, with one interval per ray.
//
// Let s be the position in the motion, from 0 (start pose) to 1 (end pose). Let t be the depth
// along a ray. A point (t, s) is in the region if depth t is in the solid at s: q(t, s) >= 0 and
// all l_j(t, s) >= 0. The region is convex. Its projection to the t axis is the sweep's interval on
// the ray.
//
//   s
// 1 ┼──╭────╮──  end pose
//   │ ╭╯    │
// 0 ┼─╰─────╯──  start pose
//   └──────────► t
//
// There are three kinds of points where the projection can end:
// - points on s = 0 or s = 1 (start pose or end pose),
// - points on a line l_j = 0 (the swept rim of a cap),
// - points where q = 0 has a vertical tangent (silhouette).
//
// Each kind is the solution of a quadratic equation. Solutions in the region are candidates, and
// the interval reaches from the smallest to the largest candidate. The silhouettes of a cone are
// two planes. They are computed as planes, so rounding never makes them one plane.
#pragma once

#include <array>

#include <kibori/solid/solid.h>

namespace kibori {

// The body before the sweep, in the tool frame [lattice units].
struct ConvexBody {
  static constexpr int kMaxPlanes = 6;

  // q(x) = x'Qx + 2b'x + c and l_j(x) = n_j'x + c_j, for x in the tool frame [lattice units]. The
  // member `q` is Q.
  Mat3 q = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  double c = 1;  // with Q = 0 and b = 0, q(x) = 1: there is no quadric
  int planes = 0;
  std::array<Vec3, kMaxPlanes> plane_normal;
  std::array<double, kMaxPlanes> plane_offset;
  // True for a circular cone with its apex at the origin. q >= 0 is then a double cone, and q is
  // not concave. Plane 0 is perpendicular to the axis and selects one half of the double cone. A
  // plane 0 through the apex adds no face. A plane 0 above the apex is the lower face of a frustum.
  bool cone = false;
  // A box that contains the body [lattice units, tool frame]. It is infinite if the body is
  // infinite.
  Box local_bounds;
  // For a rod along the axis: its thickness and the height of its top [lattice units]. For tiles
  // far above the tip, coordinates are relative to a point on the axis near the tile (kSlender). A
  // thickness of 0 means that the body is not a rod.
  double rod_thickness = 0, rod_top = 0;

  void add_plane(const Vec3& normal, double offset);
  // Returns the body, scaled about the origin by `factor`.
  ConvexBody scaled(double factor) const;
};

class SweptConvex final : public Solid {
 public:
  // `tip` and `frame` are the start pose. With `start_is_clear`, the caller promises that there is
  // no material inside the body at the start pose. `spans` may then omit rays on which the sweep
  // reaches nothing outside of that body.
  SweptConvex(const ConvexBody& body, const LatticePoint& tip, const Mat3& frame,
              const LatticeVector& motion, bool start_is_clear = false);

  LatticeBox bounds() const override { return {bounds_}; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

  // The sweep in one field's coordinates (u, v, t), relative to the tip at s = 0.
  struct View {
    double tip_u, tip_v, tip_d;
    float quu, quv, qvv, qut, qvt, qtt;  // the quadric
    float bu, bv, bt, c;
    float mu, mv, mt;            // motion
    float qm_u, qm_v, qm_t, bm;  // Q motion, b'motion
    float tt, ts, ss;            // q(t, s) = tt t^2 + 2 ts t s + ss s^2 + ...
    float s_min, s_max;
    bool moving, quadric, cone;
    // Number of planes, and the first one with a face. (A plane through an apex has none.)
    int planes, first_face;
    float nu[ConvexBody::kMaxPlanes], nv[ConvexBody::kMaxPlanes], nt[ConvexBody::kMaxPlanes];
    float offset[ConvexBody::kMaxPlanes], slope[ConvexBody::kMaxPlanes];  // slope: d l_j / d s
    // A cone's silhouettes: planes through its apex. Each has an outward normal, and t as a
    // function of u and v.
    struct Tangent {
      float nu, nv, nt, t_by_u, t_by_v;
    } tangents[2];
  };

 private:
  View view_at(const RayTile& rays) const;
  bool only_behind(const RayTile& rays) const;

  Vec3 motion_;
  Box bounds_;
  bool recentre_;  // true: each tile has an origin near the tile, along the motion
  // True for a rod that is so long that some tiles need an origin farther along its axis.
  bool is_rod_ = false;
  Vec3 axis_;
  double rod_top_ = 0, rod_near_ = 0;  // height of its top; below rod_near_, the origin is the tip
  // If set, a point x can enter the sweep only through the quadric, and only where ahead_ . (x -
  // tip_) + ahead_offset_ > 0.
  bool only_ahead_ = false;
  Vec3 tip_, ahead_;
  double ahead_offset_ = 0;
  std::array<View, 3> views_;
  // The coefficients of the views in double precision, to compute views with another origin.
  Mat3 q_;
  Vec3 b_;
  double c_;
  std::array<Vec3, ConvexBody::kMaxPlanes> plane_normal_;
  std::array<double, ConvexBody::kMaxPlanes> plane_offset_;
};

}  // namespace kibori
