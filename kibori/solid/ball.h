// SPDX-License-Identifier: MIT
// A ball swept along a straight line: a capsule, one closed-form interval per ray. The fastest
// tool, and a building block of the capsule tool.
//
// On a ray, the exit g(s) of the ball at motion parameter s is concave in s, so the exit of the
// sweep is g at its unconstrained maximum s*, clamped to the motion. With w the ray's offset in the
// (u, v) plane, p the motion's part in that plane and m = R^2 - dist(w, line)^2:
//
//   s* = w.p/|p|^2 +- (v_depth / (|p| |v|)) sqrt(m)       (+ exit, - entry)
//
#pragma once

#include <array>

#include <kibori/solid/solid.h>

namespace kibori {

class SweptBall final : public Solid {
 public:
  // `radius` in lattice units. `start_is_clear` promises that the ball at the start pose holds no
  // material; rays where the sweep adds nothing to it are then skipped, and a cut comes out the
  // same.
  SweptBall(const LatticePoint& centre, const LatticeVector& motion, double radius,
            bool start_is_clear = false);

  LatticeBox bounds() const override;
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  // Nothing left to do: `spans` knows the normals too.
  void normals(const RayTile&, int, const EndMasks&, SpanLayer&) const override {}

  // The sweep as one field sees it: everything relative to the ball's centre at the start.
  struct View {
    double centre_u, centre_v, centre_d;
    double along_u, along_v;  // w.p/|p|^2 = w.(along)
    float motion_u, motion_v, motion_d;
    float step_u, step_v;      // along_*
    float normal_u, normal_v;  // unit vector across p in the (u, v) plane; 0 where there is no p
    float shift;               // v_depth / (|p| |v|)
    float centre_depth, radius2;
    float code_scale;  // of a normal's code, from lengths
    float reach;       // |v_depth| R: dot products beyond it settle to which pose an end belongs
    // How much larger than at the end poses the squared half chord can be in between.
    float widening;
    float rim;           // for head_on: squared half chords from here up have their end at a pose
    float overlap;       // for head_on: from here up, moreover, the two poses overlap on the ray
    float s_min, s_max;  // the motion, relative to the centre above
    bool start_is_clear;
    bool head_on;  // moves along the rays, from a clear start
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
