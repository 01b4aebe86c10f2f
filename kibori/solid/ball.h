// SPDX-License-Identifier: MIT
// A ball swept along a straight line: a capsule. Each ray has one interval in closed form.
// SweptBall is the fastest tool. It is also a part of the capsule tool.
//
// Let g(s) be the depth at which a ray leaves the ball at motion parameter s. It is concave in s.
// Therefore, the ray leaves the sweep at g(s*), where s* is the maximum of g, clamped to the
// motion. Let v be the motion and p its part in the (u, v) plane. Let w be the ray's offset in that
// plane from the centre at s = 0. With m = R^2 - dist(w, line along p)^2:
//
//   s* = w.p/|p|^2 +- (v_depth / (|p| |v|)) sqrt(m)       (+ exit, - entry)
#pragma once

#include <array>

#include <kibori/solid/solid.h>

namespace kibori {

class SweptBall final : public Solid {
 public:
  // `radius` is in lattice units. With `start_is_clear`, the caller promises that there is no
  // material inside the ball at the start pose. `spans` then skips rays where the sweep adds
  // nothing to that ball. This does not change the result of a cut.
  SweptBall(const LatticePoint& centre, const LatticeVector& motion, double radius,
            bool start_is_clear = false);

  LatticeBox bounds() const override;
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  // `spans` has computed the normals.
  void normals(const RayTile&, int, const EndMasks&, SpanLayer&) const override {}

  // The sweep in one field's coordinates, relative to the ball's centre at the start.
  struct View {
    double centre_u, centre_v, centre_d;
    double along_u, along_v;  // w.p/|p|^2 = w.(along)
    float motion_u, motion_v, motion_d;
    float step_u, step_v;      // along_*
    float normal_u, normal_v;  // unit vector across p in the (u, v) plane; 0 if p is 0
    float shift;               // v_depth / (|p| |v|)
    float centre_depth, radius2;
    float code_scale;  // from lengths to a normal's code
    float reach;       // |v_depth| R: a row's pose is known if |w.p| exceeds this
    // Between the end poses, the squared half chord may exceed that of the nearer end pose by this.
    float widening;
    float rim;      // for head_on: an end belongs to an end pose if the squared half chord there is
                    // at least this
    float overlap;  // for head_on: if at least this, the two poses also overlap on the ray
    float s_min, s_max;  // range of s; s = 0 is at the centre above
    bool start_is_clear;
    bool head_on;  // the motion is along the rays, from a clear start
  };

 private:
  View view_at(const RayTile& rays) const;

  void (*kernel_)(const View&, float, float, SpanLayer&);  // for this machine's best instructions
  Vec3 centre_, motion_;
  double radius_;
  bool recentre_;
  std::array<View, 3> views_;
};

}  // namespace kibori
