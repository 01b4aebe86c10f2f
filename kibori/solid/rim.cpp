// SPDX-License-Identifier: MIT
#include <kibori/solid/rim.h>

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kibori/solid/rim.cpp"
#include <hwy/foreach_target.h>
#include <kibori/base/lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kibori {
namespace HWY_NAMESPACE {

// Newton steps on t, and on s within each; 14 x 3 brings grazing rays (where convergence is linear)
// to 1e-3 cells, all others to float32.
constexpr int kOuterSteps = 14;
constexpr int kInnerSteps = 3;

// Lengths below this [lattice units] are divided by as if they were this long: on the rim's axis,
// and where a ray meets the rim's circle itself, directions have no length. It only keeps 0 / 0
// away.
constexpr float kNoLength = 1e-12f;
// As kNoSweep, squared, in float32: (1e-9 cells)^2.
constexpr float kNoSweep2 = 1e-18f;
// The least curvature that Newton divides by; below it the bracket is halved instead.
constexpr float kNoCurvature = 1e-20f;
// A ray that nears the rim by less than this a cell, and is farther than this [cells] from it,
// passes by. Larger, and grazing rays leave ridges; smaller, and they walk on until the steps are
// used up.
constexpr float kPassing = 1e-4f;
// A walk that ends farther than this [cells] from the rim has missed it: twenty times what grazing
// rays are left with after all steps.
constexpr float kMissed = 2e-2f;

struct RimPoint {
  VF distance, slope_t, slope_s, curve_s;  // G, dG/dt, and (1/2 dG^2/ds, 1/2 d2G^2/ds2)
  VF nu, nv, nt;                           // gradient of G, any length
};

HWY_INLINE RimPoint Evaluate(const SweptRim::View& k, VF u, VF v, VF t, VF s) {
  const VF x = hn::Sub(u, hn::Mul(s, F(k.mu))), y = hn::Sub(v, hn::Mul(s, F(k.mv))),
           w = hn::Sub(t, hn::Mul(s, F(k.mt)));
  const VF z = hn::Add(hn::Add(hn::Mul(x, F(k.nu)), hn::Mul(y, F(k.nv))), hn::Mul(w, F(k.nt)));
  const VF pu = hn::Sub(x, hn::Mul(z, F(k.nu))), pv = hn::Sub(y, hn::Mul(z, F(k.nv))),
           pt = hn::Sub(w, hn::Mul(z, F(k.nt)));
  const VF rho = hn::Sqrt(hn::Add(hn::Add(hn::Mul(pu, pu), hn::Mul(pv, pv)), hn::Mul(pt, pt)));
  const VF inv_rho = hn::Div(F(1.0f), hn::Max(rho, F(kNoLength)));
  const VF e = hn::Max(hn::Sub(rho, F(k.disc_radius)), F(0.0f));
  const float mn = k.mu * k.nu + k.mv * k.nv + k.mt * k.nt;
  const float m2 = k.mu * k.mu + k.mv * k.mv + k.mt * k.mt;
  const VF pm = hn::Mul(
      hn::Add(hn::Add(hn::Mul(pu, F(k.mu)), hn::Mul(pv, F(k.mv))), hn::Mul(pt, F(k.mt))), inv_rho);
  RimPoint p;
  const VF g2 = hn::Add(hn::Mul(e, e), hn::Mul(z, z));
  p.distance = hn::Sqrt(g2);
  const VF inv_g = hn::Div(F(1.0f), hn::Max(p.distance, F(kNoLength)));
  const VF ratio = hn::Mul(e, inv_rho);
  p.nu = hn::Add(hn::Mul(ratio, pu), hn::Mul(z, F(k.nu)));
  p.nv = hn::Add(hn::Mul(ratio, pv), hn::Mul(z, F(k.nv)));
  p.nt = hn::Add(hn::Mul(ratio, pt), hn::Mul(z, F(k.nt)));
  p.slope_t = hn::Mul(p.nt, inv_g);
  p.slope_s = hn::Neg(hn::Add(hn::Mul(e, pm), hn::Mul(z, F(mn))));
  const VF active = hn::IfThenElseZero(hn::Gt(e, hn::Zero(DF())), F(1.0f));
  const VF across = hn::Max(hn::Sub(F(m2 - mn * mn), hn::Mul(pm, pm)), F(0.0f));
  p.curve_s =
      hn::Add(hn::Add(hn::Mul(active, hn::Mul(pm, pm)), hn::Mul(ratio, across)), F(mn * mn));
  return p;
}

// The end of the interval reached from `t`, walking up (`up`) or down the ray.
HWY_INLINE VF Walk(const SweptRim::View& k, VF u, VF v, VF t, bool up, MF& live, RimPoint& at) {
  const DF d;
  const VF s_min = F(k.s_min), s_max = F(k.s_max);
  VF s = F(0.5f * (k.s_min + k.s_max));
  const float m2 = k.mu * k.mu + k.mv * k.mv + k.mt * k.mt;
  const bool moving = m2 > kNoSweep2;
  if (moving) {
    s = hn::Mul(hn::Add(hn::Add(hn::Mul(u, F(k.mu)), hn::Mul(v, F(k.mv))), hn::Mul(t, F(k.mt))),
                F(1.0f / m2));
    s = hn::Min(hn::Max(s, s_min), s_max);
  }
  const float direction = up ? 1.0f : -1.0f;
  MF missed = hn::FirstN(d, 0);
  for (int outer = 0; outer < kOuterSteps; outer++) {
    if (moving) {
      VF left = s_min, right = s_max;
      for (int inner = 0; inner < kInnerSteps + (outer == 0 ? 8 : 0); inner++) {
        const RimPoint p = Evaluate(k, u, v, t, s);
        const MF rising = hn::Gt(p.slope_s, hn::Zero(d));
        right = hn::IfThenElse(rising, s, right);
        left = hn::IfThenElse(rising, left, s);
        const VF newton = hn::Sub(s, hn::Div(p.slope_s, hn::Max(p.curve_s, F(kNoCurvature))));
        const MF inside = hn::And(hn::Ge(newton, left), hn::Le(newton, right));
        const MF flat = hn::Eq(p.slope_s, hn::Zero(d));
        s = hn::IfThenElse(flat, s,
                           hn::IfThenElse(inside, newton, hn::Mul(hn::Add(left, right), F(0.5f))));
      }
    }
    at = Evaluate(k, u, v, t, s);
    const VF excess = hn::Sub(at.distance, F(k.corner));
    // G is convex in (t, s): no s brings it lower here than its tangent plane allows. What an s
    // that has not settled might yet gain is no reason to walk further, nor to give the ray up.
    const VF slope_s = hn::Div(at.slope_s, hn::Max(at.distance, F(kNoLength)));
    const VF gain =
        hn::Max(hn::Mul(slope_s, hn::Sub(s, s_min)), hn::Mul(slope_s, hn::Sub(s, s_max)));
    const VF sure = hn::IfThenElse(hn::Gt(excess, hn::Zero(d)),
                                   hn::Max(hn::Sub(excess, gain), hn::Zero(d)), excess);
    // Walking up, H falls until the near end is met; where it no longer falls, the ray passes by.
    const VF slope = hn::Mul(at.slope_t, F(direction));
    const MF passing = hn::And(hn::Ge(slope, F(-kPassing)), hn::Gt(sure, F(kPassing)));
    missed = hn::Or(missed, passing);
    const VF step = hn::Div(sure, hn::Max(hn::Neg(slope), F(kPassing)));
    t = hn::IfThenElse(missed, t, hn::Add(t, hn::Mul(step, F(direction))));
  }
  live = hn::And(live, hn::AndNot(missed, hn::Lt(hn::Sub(at.distance, F(k.corner)), F(kMissed))));
  return t;
}

// Turns the enclosing interval of `layer` into the rim's own.
void RimSpans(const SweptRim::View& k, SpanLayer& layer) {
  const DF d;
  unsigned rows = 0;
  for (int row = 0; row < kTileSide; row++) {
    if (!((layer.rows >> row) & 1)) continue;
    for (size_t g = 0; g < kGroups; g++) {
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      const VF u = LanesFrom(k.u_base, g), v = F(k.v_base + static_cast<float>(row));
      VF lo = hn::Load(d, layer.lo + slot), hi = hn::Load(d, layer.hi + slot);
      MF live = hn::Lt(lo, hi);
      if (!hn::AllFalse(d, live)) {
        RimPoint at;
        const VF start = hn::IfThenElse(live, hn::Sub(lo, F(k.depth)), hn::Zero(d));
        const VF stop = hn::IfThenElse(live, hn::Sub(hi, F(k.depth)), hn::Zero(d));
        lo = hn::Add(Walk(k, u, v, start, true, live, at), F(k.depth));
        hi = hn::Add(Walk(k, u, v, stop, false, live, at), F(k.depth));
        live = hn::And(live, hn::Lt(lo, hi));
        if (!hn::AllFalse(d, live)) rows |= 1u << row;
      }
      hn::Store(hn::IfThenElse(live, lo, F(kFar)), d, layer.lo + slot);
      hn::Store(hn::IfThenElse(live, hi, F(-kFar)), d, layer.hi + slot);
    }
  }
  layer.rows = static_cast<uint16_t>(rows);
}

void RimNormals(const SweptRim::View& k, const EndMasks& ends, SpanLayer& of) {
  const DF d;
  const DU du;
  const auto encode = [&](const float* depth, VF u, VF v, uint32_t* to) HWY_ATTR {
    const VF t = hn::Sub(hn::Load(d, depth), F(k.depth));
    const float m2 = k.mu * k.mu + k.mv * k.mv + k.mt * k.mt;
    VF s = hn::Zero(d);
    if (m2 > kNoSweep2) {
      s = hn::Mul(hn::Add(hn::Add(hn::Mul(u, F(k.mu)), hn::Mul(v, F(k.mv))), hn::Mul(t, F(k.mt))),
                  F(1.0f / m2));
      s = hn::Min(hn::Max(s, F(k.s_min)), F(k.s_max));
      VF left = F(k.s_min), right = F(k.s_max);
      for (int i = 0; i < 16; i++) {
        const RimPoint p = Evaluate(k, u, v, t, s);
        const MF rising = hn::Gt(p.slope_s, hn::Zero(d));
        right = hn::IfThenElse(rising, s, right);
        left = hn::IfThenElse(rising, left, s);
        const VF newton = hn::Sub(s, hn::Div(p.slope_s, hn::Max(p.curve_s, F(kNoCurvature))));
        const MF inside = hn::And(hn::Ge(newton, left), hn::Le(newton, right));
        s = hn::IfThenElse(inside, newton, hn::Mul(hn::Add(left, right), F(0.5f)));
      }
    }
    const RimPoint p = Evaluate(k, u, v, t, s);
    hn::Store(EncodeNormal(p.nu, p.nv, p.nt, NormalScale(of.flip)), du, to);
  };
  for (unsigned left = ends.rows; left; left &= left - 1) {
    const int row = __builtin_ctz(left);
    for (size_t g = 0; g < kGroups; g++) {
      const unsigned group = kGroupMask << (g * kLanes);
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      const VF u = LanesFrom(k.u_base, g), v = F(k.v_base + static_cast<float>(row));
      if (ends.lo[row] & group) encode(of.lo + slot, u, v, of.codes.lo + slot);
      if (ends.hi[row] & group) encode(of.hi + slot, u, v, of.codes.hi + slot);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kibori
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kibori {
HWY_EXPORT(RimSpans);
HWY_EXPORT(RimNormals);

namespace {
ConvexBody enclosing_cylinder(double disc_radius, double corner) {
  const double radius = disc_radius + corner;
  ConvexBody body;
  body.q.diagonal() << -1, -1, 0;
  body.c = radius * radius;
  body.add_plane(Vec3(0, 0, 1), corner);
  body.add_plane(Vec3(0, 0, -1), corner);
  body.local_bounds = {Vec3(-radius, -radius, -corner), Vec3(radius, radius, corner)};
  return body;
}
}  // namespace

SweptRim::SweptRim(const LatticePoint& centre, const Mat3& frame, double disc_radius, double corner,
                   const LatticeVector& motion)
    : centre_(centre.units),
      axis_(frame.col(2)),
      motion_(motion.units),
      disc_radius_(disc_radius),
      corner_(corner),
      hull_(enclosing_cylinder(disc_radius, corner), centre, frame, motion) {}

SweptRim::View SweptRim::view_at(const RayTile& rays) const {
  const int u = u_index(rays.axis), v = v_index(rays.axis), t = depth_index(rays.axis);
  const auto f = [](double x) { return static_cast<float>(x); };
  const double half = 0.5 * kTileSide, flat2 = motion_[u] * motion_[u] + motion_[v] * motion_[v];
  double s = 0;
  if (flat2 > kRecentreLength * kRecentreLength)
    s = std::clamp(
        ((rays.u0 + half - centre_[u]) * motion_[u] + (rays.v0 + half - centre_[v]) * motion_[v]) /
            flat2,
        0.0, 1.0);
  const Vec3 centre = centre_ + s * motion_;
  View k;
  k.u_base = f(rays.u0 + 0.5 - centre[u]);
  k.v_base = f(rays.v0 + 0.5 - centre[v]);
  k.depth = f(centre[t]);
  k.mu = f(motion_[u]);
  k.mv = f(motion_[v]);
  k.mt = f(motion_[t]);
  k.nu = f(axis_[u]);
  k.nv = f(axis_[v]);
  k.nt = f(axis_[t]);
  k.disc_radius = f(disc_radius_);
  k.corner = f(corner_);
  k.s_min = f(-s);
  k.s_max = f(1 - s);
  return k;
}

bool SweptRim::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  if (!hull_.spans(rays, layer, out)) return false;
  out.normals_ready = 0;
  HWY_DYNAMIC_DISPATCH(RimSpans)(view_at(rays), out);
  return out.rows != 0;
}

void SweptRim::normals(const RayTile& rays, int, const EndMasks& ends, SpanLayer& of) const {
  HWY_DYNAMIC_DISPATCH(RimNormals)(view_at(rays), ends, of);
}

}  // namespace kibori
#endif
