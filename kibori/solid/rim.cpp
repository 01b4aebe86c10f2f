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

// Maximum number of Newton steps on t, and on s within each. After 14 x 3 steps, the error of
// grazing rays, which converge linearly, is 1e-3 cells. All other rays have the precision of
// float32.
constexpr int kOuterSteps = 14;
constexpr int kInnerSteps = 3;
// Maximum number of steps to the rim at one pose, and of poses. Each step solves a quadratic, which
// is exact for a ray along the axis.
constexpr int kPoseSteps = 6;
constexpr int kPoses = 2;
// A ray within this distance of the rim [cells] is on it.
constexpr float kThere = 1e-5f;
// Maximum number of steps for the first s, and for the s of a normal.
constexpr int kFirstSteps = 11, kNormalSteps = 16;
// A ray whose step is shorter than this [cells] is finished, even if other rays of its vector
// continue. Therefore, the vector width does not change the result.
constexpr float kSettled = 1e-4f;
// s is refined if that may gain more than this share of the remaining distance.
constexpr float kMuch = 0.1f;

// A ray is parallel to the disc if its height above the disc changes by less than this per unit of
// depth.
constexpr float kParallel = 1e-12f;
// Minimum of a length [lattice units] that is a divisor. On the rim's axis, and where a ray
// meets the rim's circle, a length can be 0. The value only prevents 0 / 0.
constexpr float kNoLength = 1e-12f;
// kNoSweep, squared, in float32: (1e-9 cells)^2.
constexpr float kNoSweep2 = 1e-18f;
// Minimum curvature for a Newton step; below it the bracket is halved.
constexpr float kNoCurvature = 1e-20f;
// A ray misses the rim if it approaches by less than this per cell and is farther than this [cells]
// away. With a larger value, grazing rays are lost, and ridges remain. With a smaller one, they use
// all steps.
constexpr float kPassing = 1e-4f;
// If the search ends farther than this [cells] from the rim, the ray misses it. This is twenty
// times the error of grazing rays after all steps.
constexpr float kMissed = 2e-2f;

struct RimPoint {
  VF distance, slope_t;           // G, dG/dt
  VF slope_s, curve_s, curve_ts;  // of G^2 / 2: its derivatives by s, s twice, and t and s
  VF nu, nv, nt;                  // gradient of G, any length
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
  // The derivative of (pu, pv, pt) by t is the part of the ray's direction across the axis.
  const VF out_t = hn::Mul(pt, inv_rho);
  const VF pm_t = hn::Mul(hn::Sub(F(k.mt - k.nt * mn), hn::Mul(pm, out_t)), inv_rho);
  p.curve_ts = hn::Neg(
      hn::Add(hn::Add(hn::Mul(active, hn::Mul(out_t, pm)), hn::Mul(e, pm_t)), F(k.nt * mn)));
  return p;
}

// The s nearest to the ray's point t. Starts at `s`, for the rays in `walk`, with at most `steps`
// steps.
HWY_INLINE VF Nearest(const SweptRim::View& k, VF u, VF v, VF t, VF s, MF walk, int steps) {
  const DF d;
  const float m2 = k.mu * k.mu + k.mv * k.mv + k.mt * k.mt;
  const VF settled2 = F(kSettled * kSettled / m2);
  const VF left_end = F(k.s_min), right_end = F(k.s_max);
  VF left = left_end, right = right_end;
  for (int i = 0; i < steps && !hn::AllFalse(d, walk); i++) {
    const RimPoint p = Evaluate(k, u, v, t, s);
    const MF rising = hn::Gt(p.slope_s, hn::Zero(d));
    right = hn::IfThenElse(rising, s, right);
    left = hn::IfThenElse(rising, left, s);
    const VF newton = hn::Sub(s, hn::Div(p.slope_s, hn::Max(p.curve_s, F(kNoCurvature))));
    const MF inside = hn::And(hn::Ge(newton, left), hn::Le(newton, right));
    // In the first step, the result is only clamped to the bounds, because many rays are nearest
    // exactly there.
    const VF beyond = i == 0 ? hn::Min(hn::Max(newton, left_end), right_end)
                             : hn::Mul(hn::Add(left, right), F(0.5f));
    const VF to = hn::IfThenElse(inside, newton, beyond);
    walk = hn::AndNot(hn::Eq(p.slope_s, hn::Zero(d)), walk);
    const VF step = hn::Sub(to, s);
    s = hn::IfThenElse(walk, to, s);
    walk = hn::And(walk, hn::Gt(hn::Mul(step, step), settled2));
  }
  return s;
}

// The s at which the disc's centre is nearest to a ray's point at t.
HWY_INLINE VF ClosestToMiddle(const SweptRim::View& k, VF u, VF v, VF t, float m2) {
  const VF s =
      hn::Mul(hn::Add(hn::Add(hn::Mul(u, F(k.mu)), hn::Mul(v, F(k.mv))), hn::Mul(t, F(k.mt))),
              F(1.0f / m2));
  return hn::Min(hn::Max(s, F(k.s_min)), F(k.s_max));
}

// Walks from `t` to the end of the rim at the pose `s` of each ray. If the ray misses that rim, it
// walks to the nearest point. The first time, rays inside that rim stay, and `walk` drops them. No
// step is longer than four times `length`, the ray's length within the enclosing ball. Below the
// disc, the distance to the disc does not depend on its edge. So a step could be so long that
// float32 cannot return from it.
HWY_INLINE VF WalkAtPose(const SweptRim::View& k, VF u, VF v, VF t, VF s, VF length,
                         float direction, bool first, MF& walk) {
  const DF d;
  const VF zero = hn::Zero(d);
  // The vector from the disc's centre at that pose to the ray's point at t + x. Its component along
  // the disc's axis is z + x nt. The square of its length across the axis is square + 2 x at + x^2
  // a.
  const VF pu = hn::Sub(u, hn::Mul(s, F(k.mu))), pv = hn::Sub(v, hn::Mul(s, F(k.mv))),
           pt = hn::Sub(t, hn::Mul(s, F(k.mt)));
  const VF z = hn::Add(hn::Add(hn::Mul(pu, F(k.nu)), hn::Mul(pv, F(k.nv))), hn::Mul(pt, F(k.nt)));
  const VF au = hn::Sub(pu, hn::Mul(z, F(k.nu))), av = hn::Sub(pv, hn::Mul(z, F(k.nv))),
           at = hn::Sub(pt, hn::Mul(z, F(k.nt)));
  const VF square = hn::Add(hn::Add(hn::Mul(au, au), hn::Mul(av, av)), hn::Mul(at, at));
  const float a = k.nu * k.nu + k.nv * k.nv;
  const VF max_step = hn::Mul(length, F(4.0f));
  VF x = zero;
  MF left = walk;
  for (int i = 0; i < kPoseSteps && !hn::AllFalse(d, left); i++) {
    const VF half = hn::Add(at, hn::Mul(x, F(a)));  // half the derivative of the square
    const VF rho2 = hn::Add(square, hn::Mul(x, hn::Add(at, half)));
    const VF rho = hn::Max(hn::Sqrt(hn::Max(rho2, zero)), F(kNoLength));
    const VF inverse = hn::Div(F(1.0f), rho), out = hn::Mul(half, inverse);
    const VF e = hn::Max(hn::Sub(rho, F(k.disc_radius)), zero);
    const VF height = hn::Add(z, hn::Mul(x, F(k.nt)));
    // f = G^2 - corner^2. `falling` is half its decrease per unit of the walk, `curve` half its
    // second derivative.
    const VF f = hn::Sub(hn::Add(hn::Mul(e, e), hn::Mul(height, height)), F(k.corner * k.corner));
    const VF falling = hn::Mul(hn::Add(hn::Mul(e, out), hn::Mul(height, F(k.nt))), F(-direction));
    const VF out2 = hn::Mul(out, out);
    const VF bends = hn::Add(out2, hn::Mul(hn::Mul(e, inverse), hn::Sub(F(a), out2)));
    const VF curve = hn::Add(F(k.nt * k.nt), hn::IfThenElseZero(hn::Gt(e, zero), bends));
    if (i == 0 && first) left = walk = hn::And(walk, hn::Gt(f, F(2 * kThere * k.corner)));
    const VF disc = hn::Sub(hn::Mul(falling, falling), hn::Mul(curve, f));
    const MF passing = hn::And(hn::Gt(f, zero), hn::Or(hn::Lt(disc, zero), hn::Le(falling, zero)));
    const VF then = hn::Sqrt(hn::Max(disc, zero)), root = hn::Add(falling, then);
    const VF whole = hn::Div(hn::IfThenElse(passing, falling, f),
                             hn::Max(hn::IfThenElse(passing, curve, root), F(kNoLength)));
    const VF step = hn::Max(hn::Min(whole, max_step), hn::Neg(max_step));
    x = hn::IfThenElse(left, hn::Add(x, hn::Mul(step, F(direction))), x);
    // The error of the quadratic is at most a^(3/2) step^3 / rho, divided by the slope of f there.
    const VF apart = hn::Mul(step, hn::Mul(step, step));
    left = hn::And(left, hn::Gt(hn::Abs(hn::Mul(apart, F(a * std::sqrt(a)))),
                                hn::Mul(hn::Mul(rho, then), F(kSettled))));
    left = hn::And(left, hn::Gt(hn::Abs(step), F(kSettled)));
  }
  return hn::Add(t, x);
}

// The end of the interval, reached from `t` by walking up (`up`) or down the ray. `length` is the
// ray's length within the enclosing ball. Rays that are inside the rim at `t` stay.
HWY_INLINE VF Walk(const SweptRim::View& k, VF u, VF v, VF t, VF length, bool up, MF& live) {
  const DF d;
  const VF s_min = F(k.s_min), s_max = F(k.s_max);
  const float m2 = k.mu * k.mu + k.mv * k.mv + k.mt * k.mt;
  VF s = m2 > kNoSweep2 ? ClosestToMiddle(k, u, v, t, m2) : F(0.5f * (k.s_min + k.s_max));
  const float direction = up ? 1.0f : -1.0f;
  // Where s has not converged, a better s may make G smaller. G is convex in (t, s), so it is
  // nowhere below its tangent plane. This bounds the possible gain, which gain_of returns.
  const auto gain_of = [&](const RimPoint& p) HWY_ATTR {
    const VF slope_s = hn::Div(p.slope_s, hn::Max(p.distance, F(kNoLength)));
    return hn::Max(hn::Mul(slope_s, hn::Sub(s, s_min)), hn::Mul(slope_s, hn::Sub(s, s_max)));
  };
  MF walk = live;
  VF there = t;
  for (int i = 0; i < kPoses && !hn::AllFalse(d, walk); i++) {
    there = WalkAtPose(k, u, v, there, s, length, direction, i == 0, walk);
    if (hn::AllFalse(d, walk)) break;
    const RimPoint at = Evaluate(k, u, v, there, s);
    const VF gain = gain_of(at), excess = hn::Sub(at.distance, F(k.corner));
    // True at the rim's near end. At its far end, the distance grows along the walk.
    const MF near = hn::Le(hn::Mul(at.slope_t, F(direction)), F(kPassing));
    const MF arrived =
        hn::And(hn::And(walk, near), hn::Le(hn::Max(hn::Abs(excess), gain), F(kSettled)));
    const VF farthest = hn::Add(length, hn::Abs(hn::Sub(there, t)));
    t = hn::IfThenElse(arrived, there, t);
    const VF sure = hn::Sub(hn::Sub(excess, gain), hn::Mul(hn::Abs(at.slope_t), farthest));
    const MF passing = hn::And(walk, hn::Gt(sure, F(kSettled)));
    live = hn::AndNot(passing, live);
    walk = hn::AndNot(hn::Or(arrived, passing), walk);
    const VF to = hn::Sub(s, hn::Div(at.slope_s, hn::Max(at.curve_s, F(kNoCurvature))));
    s = hn::IfThenElse(walk, hn::Min(hn::Max(to, s_min), s_max), s);
  }
  MF missed = hn::FirstN(d, 0);
  VF excess = hn::Zero(d);
  for (int outer = 0; outer < kOuterSteps && !hn::AllFalse(d, walk); outer++) {
    RimPoint at = Evaluate(k, u, v, t, s);
    // A better s may reduce G by up to `gain`. So the distance minus `gain` decides whether the ray
    // goes further, or is dropped.
    VF gain = gain_of(at);
    const VF much = hn::Max(F(kSettled), hn::Mul(hn::Sub(at.distance, F(k.corner)), F(kMuch)));
    const MF off = hn::And(walk, hn::Gt(gain, much));
    if (!hn::AllFalse(d, off)) {
      s = Nearest(k, u, v, t, s, off, outer == 0 ? kFirstSteps : kInnerSteps);
      at = Evaluate(k, u, v, t, s);
      gain = gain_of(at);
    }
    excess = hn::IfThenElse(walk, hn::Sub(at.distance, F(k.corner)), excess);
    if (outer == 0) walk = hn::And(walk, hn::Gt(excess, hn::Zero(d)));
    const VF sure = hn::IfThenElse(hn::Gt(excess, hn::Zero(d)),
                                   hn::Max(hn::Sub(excess, gain), hn::Zero(d)), excess);
    // Along the walk, H decreases until the near end of the rim. If it no longer decreases, the
    // ray misses the rim.
    const VF slope = hn::Mul(at.slope_t, F(direction));
    const MF passing =
        hn::And(walk, hn::And(hn::Ge(slope, F(-kPassing)), hn::Gt(sure, F(kPassing))));
    missed = hn::Or(missed, passing);
    walk = hn::AndNot(passing, walk);
    const VF step = hn::Div(sure, hn::Max(hn::Neg(slope), F(kPassing)));
    const VF by = hn::IfThenElseZero(walk, hn::Mul(step, F(direction)));
    t = hn::Add(t, by);
    // The nearest s moves with t, unless it is at an end.
    const VF with = hn::Div(at.curve_ts, hn::Max(at.curve_s, F(kNoCurvature)));
    const MF between = hn::And(hn::Gt(s, s_min), hn::Lt(s, s_max));
    const VF moved = hn::Min(hn::Max(hn::Sub(s, hn::Mul(by, with)), s_min), s_max);
    s = hn::IfThenElse(between, moved, s);
    walk = hn::And(walk, hn::Or(hn::Gt(hn::Abs(step), F(kSettled)), hn::Gt(gain, F(kSettled))));
  }
  live = hn::And(live, hn::AndNot(missed, hn::Lt(excess, F(kMissed))));
  return t;
}

// Turns the enclosing ball's interval of `layer` into the rim's own.
void RimSpans(const SweptRim::View& k, SpanLayer& layer) {
  const DF d;
  // A ray crosses a height at (height - base) / nt.
  const bool crosses = std::abs(k.nt) > kParallel;
  const float per_height = crosses ? 1.0f / k.nt : 0.0f;
  unsigned rows = 0;
  for (int row = 0; row < kTileSide; row++) {
    if (!((layer.rows >> row) & 1)) continue;
    for (size_t g = 0; g < kGroups; g++) {
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      const VF u = LanesFrom(k.u_base, g), v = F(k.v_base + static_cast<float>(row));
      VF lo = hn::Sub(hn::Load(d, layer.lo + slot), F(k.depth)),
         hi = hn::Sub(hn::Load(d, layer.hi + slot), F(k.depth));
      const VF base = hn::Add(hn::Mul(u, F(k.nu)), hn::Mul(v, F(k.nv)));
      const VF below = hn::Sub(F(k.low), base), above = hn::Sub(F(k.high), base);
      MF live = hn::Lt(lo, hi);
      if (crosses) {
        const VF a = hn::Mul(below, F(per_height)), b = hn::Mul(above, F(per_height));
        lo = hn::Max(lo, hn::Min(a, b));
        hi = hn::Min(hi, hn::Max(a, b));
        live = hn::And(live, hn::Lt(lo, hi));
      } else {
        live = hn::And(live, hn::And(hn::Le(below, hn::Zero(d)), hn::Ge(above, hn::Zero(d))));
      }
      if (!hn::AllFalse(d, live)) {
        const VF start = hn::IfThenElseZero(live, lo), stop = hn::IfThenElseZero(live, hi);
        const VF length = hn::Sub(stop, start);
        lo = hn::Add(Walk(k, u, v, start, length, true, live), F(k.depth));
        hi = hn::Add(Walk(k, u, v, stop, length, false, live), F(k.depth));
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
    if (m2 > kNoSweep2)
      s = Nearest(k, u, v, t, ClosestToMiddle(k, u, v, t, m2), hn::Eq(s, s), kNormalSteps);
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
// How far the rim reaches above its disc, into the shank [cells]. It exceeds the float32 error of a
// position.
constexpr double kInShank = 1e-3;
}  // namespace

SweptRim::SweptRim(const LatticePoint& centre, const Mat3& frame, double disc_radius, double corner,
                   const LatticeVector& motion, bool start_is_clear)
    : centre_(centre.units),
      axis_(frame.col(2)),
      motion_(motion.units),
      disc_radius_(disc_radius),
      corner_(corner),
      start_is_clear_(start_is_clear && !motion.units.isZero(0)),
      hull_(centre, motion, disc_radius + corner) {
  // `whole` is the box of the whole rim. `half` is the box of its lower half, computed from a
  // tilted box around it. Depending on the axis, either may be smaller, so the bounds are their
  // intersection.
  Box whole, half;
  const Vec3 reach =
      disc_radius * (Vec3::Ones() - axis_.cwiseProduct(axis_)).cwiseMax(0).cwiseSqrt() +
      Vec3::Constant(corner);
  const double radius = disc_radius + corner;
  for (const double s : {0.0, 1.0}) {
    const Vec3 at = centre_ + s * motion_;
    whole.include(Vec3(at - reach));
    whole.include(Vec3(at + reach));
    for (int i = 0; i < 8; i++)
      half.include(Vec3(at + frame * Vec3(i & 1 ? radius : -radius, i & 2 ? radius : -radius,
                                          i & 4 ? kInShank : -corner)));
  }
  bounds_ = {Box{whole.min.cwiseMax(half.min), whole.max.cwiseMin(half.max)}};
}

// True if the sweep reaches nothing on these rays beyond the start pose. The distance from a point
// to the moving disc is a convex function of s. Therefore, if the point enters the sweep, the
// distance decreases from s = 0 on. If the point is below the disc and the motion does not lead
// down, the motion must then lead away from the axis.
bool SweptRim::only_behind(const RayTile& rays) const {
  const double up = axis_.dot(motion_);
  return up >= 0 && max_over_rays(rays, bounds_.units, motion_ - up * axis_, centre_) <= 0;
}

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
  const double up = axis_.dot(motion_);
  k.low = f(std::min(-s * up, (1 - s) * up) - corner_);
  k.high = f(std::max(-s * up, (1 - s) * up) + kInShank);
  return k;
}

bool SweptRim::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  if (layer != 0 || (start_is_clear_ && only_behind(rays)) || !hull_.spans(rays, layer, out))
    return false;
  out.normals_ready = 0;
  HWY_DYNAMIC_DISPATCH(RimSpans)(view_at(rays), out);
  return out.rows != 0;
}

void SweptRim::normals(const RayTile& rays, int, const EndMasks& ends, SpanLayer& of) const {
  HWY_DYNAMIC_DISPATCH(RimNormals)(view_at(rays), ends, of);
}

}  // namespace kibori
#endif
