// SPDX-License-Identifier: MIT
// A ball swept along a straight line. The sweep is a capsule. Each ray has one interval, and
// formulas give its ends. SweptBall is the fastest tool. The capsule tool has it as a part.
//
// Let s be the position in the motion: 0 at its start, 1 at its end. Let g(s) be the depth at which
// a ray leaves the ball at s. The function g is concave. Therefore, the ray leaves the sweep at
// g(s*). Here s* is the s at which g is largest, clamped to the range of s. Let v be the motion and
// p its part in the (u, v) plane. Let w be the ray's offset in that plane from the ball's centre at
// s = 0. Let m = R^2 - (distance of w from the line along p)^2. Then, before the clamp:
//
//   s* = w.p/|p|^2 +- (v_depth / (|p| |v|)) sqrt(m)       (+ for the exit, - for the entry)
#pragma once

#include <array>

#include <kibori/solid/solid.h>

namespace kibori {

class SweptBall final : public Solid {
 public:
  // `radius` is in lattice units. With `start_is_clear`, the caller promises that there is no
  // material inside the ball at the start pose. `spans` then skips rays on which the sweep reaches
  // nothing outside of that ball. This does not change the result of a cut.
  SweptBall(const LatticePoint& centre, const LatticeVector& motion, double radius,
            bool start_is_clear = false);

  LatticeBox bounds() const override;
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  // Does nothing: `spans` has already computed the normals.
  void normals(const RayTile&, int, const EndMasks&, SpanLayer&) const override {}

  // The sweep in one field's coordinates. A pose is the ball at one s; the two end poses are the
  // first pose (s_min) and the last pose (s_max). The half chord at a pose is half the length of
  // the ray's interval in the ball.
  struct View {
    double centre_u, centre_v, centre_d;
    double along_u, along_v;  // p/|p|^2, so that w.p/|p|^2 = w.along
    float motion_u, motion_v, motion_d;
    float step_u, step_v;      // along_u and along_v as float32
    float normal_u, normal_v;  // p/|p|; 0 if p is 0
    float shift;               // v_depth / (|p| |v|), the factor of sqrt(m)
    float centre_depth, radius2;
    float code_scale;  // factor from a vector of length R to the vector that is encoded as a normal
    float reach;       // |v_depth| R and slack; if |w.p| exceeds it, both ends are at one end pose
    // Between the end poses, the squared half chord may exceed the one at the nearer end pose by
    // this.
    float widening;
    // For head_on: an end belongs to an end pose if the squared half chord at this pose is at least
    // `rim`. If it is at least `overlap` at both end poses, their intervals on the ray also
    // overlap.
    float rim;
    float overlap;
    float s_min, s_max;  // range of s; at s = 0, the ball's centre is `centre`
    bool start_is_clear;
    bool head_on;  // the motion is nearly along the rays, and start_is_clear
  };

 private:
  View view_at(const RayTile& rays) const;

  void (*kernel_)(const View&, float, float, SpanLayer&);  // for the processor's best vector unit
  Vec3 centre_, motion_;
  double radius_;
  bool recentre_;
  std::array<View, 3> views_;
};

}  // namespace kibori
