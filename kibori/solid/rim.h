// SPDX-License-Identifier: MIT
// The rounded rim of a bull-nose cutter, swept: all points within `corner` of a disc that moves
// along a straight line.
//
// The distance G(t, s) from a ray's point t to the disc at motion parameter s is convex, so each
// end of the interval is the root of a convex function of t, H(t) = min over s of G(t, s) = corner.
// Newton walks to it from the end of the enclosing swept cylinder, with s refined a few steps along
// each time; the number of steps is fixed.
#pragma once

#include <kibori/solid/convex.h>
#include <kibori/solid/solid.h>

namespace kibori {

class SweptRim final : public Solid {
 public:
  // Centre of the disc at the start, its frame (z: its axis), radii of disc and corner [lattice
  // units], motion.
  SweptRim(const LatticePoint& centre, const Mat3& frame, double disc_radius, double corner,
           const LatticeVector& motion);

  LatticeBox bounds() const override { return hull_.bounds(); }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

  struct View {
    float u_base, v_base, depth;  // of ray (0, 0) relative to the disc's centre; the centre's depth
    float mu, mv, mt, nu, nv, nt;
    float disc_radius, corner, s_min, s_max;
  };

 private:
  View view_at(const RayTile& rays) const;

  Vec3 centre_, axis_, motion_;
  double disc_radius_, corner_;
  SweptConvex hull_;  // the cylinder that just holds the rim
};

}  // namespace kibori
