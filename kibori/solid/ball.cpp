// SPDX-License-Identifier: MIT
#include <kibori/solid/ball.h>

#include <algorithm>
#include <cmath>

#include <kibori/base/vector_unit.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kibori/solid/ball.cpp"
#include <hwy/foreach_target.h>
#include <kibori/base/lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kibori {
namespace HWY_NAMESPACE {

// The ends of the sweep in one group of lanes, by the formula of ball.h. `live` marks lanes that
// meet the sweep. `old` marks lanes on which both ends belong to the first pose. (ball.h defines
// first and last pose.)
struct Ends {
  VF lo, hi;
  MF live, old;
  VU code_lo, code_hi;
};
HWY_INLINE Ends SweepEnds(const SweptBall::View& k, VF u, float v_row, VF code_scale) {
  const DF d;
  const VF r2 = F(k.radius2), s_min = F(k.s_min), s_max = F(k.s_max), v = F(v_row);
  const VF zero = hn::Zero(d), centre = F(k.centre_depth);
  const VF s0 = hn::Add(hn::Mul(u, F(k.step_u)), F(v_row * k.step_v));
  const VF across = hn::Sub(hn::Mul(u, F(k.normal_v)), F(v_row * k.normal_u));
  const VF turn =
      hn::Mul(hn::Sqrt(hn::Max(hn::Sub(r2, hn::Mul(across, across)), zero)), F(k.shift));
  const VF s_lo = hn::Min(hn::Max(hn::Sub(s0, turn), s_min), s_max);
  const VF s_hi = hn::Min(hn::Max(hn::Add(s0, turn), s_min), s_max);
  // (u, v) is the ray's offset from the ball's centre at one s. `rest` is R^2 minus its squared
  // length. Where it is positive, it is the squared half chord.
  struct Pose {
    VF u, v, rest;
  };
  const auto at = [&](VF s) HWY_ATTR {
    const VF pu = hn::Sub(u, hn::Mul(s, F(k.motion_u))), pv = hn::Sub(v, hn::Mul(s, F(k.motion_v)));
    return Pose{pu, pv, hn::Sub(hn::Sub(r2, hn::Mul(pv, pv)), hn::Mul(pu, pu))};
  };
  const Pose lo = at(s_lo), hi = at(s_hi);
  // A ray meets the sweep if it meets the ball at the pose that is nearest to the ray. `rest` at
  // s_lo and s_hi would not be a reliable test. If the motion is nearly along the ray, it is almost
  // 0 there, and rounding would decide.
  const Pose nearest = at(hn::Min(hn::Max(s0, s_min), s_max));
  Ends ends;
  ends.live = hn::Gt(nearest.rest, zero);
  ends.old = hn::Eq(hn::Max(s_lo, s_hi), s_min);
  ends.lo =
      hn::Sub(hn::Add(centre, hn::Mul(s_lo, F(k.motion_d))), hn::Sqrt(hn::Max(lo.rest, zero)));
  ends.hi =
      hn::Add(hn::Add(centre, hn::Mul(s_hi, F(k.motion_d))), hn::Sqrt(hn::Max(hi.rest, zero)));
  ends.code_lo = EncodeScaled(lo.u, lo.v, code_scale);
  ends.code_hi = EncodeScaled(hi.u, hi.v, code_scale);
  return ends;
}

// Properties of the rows of a tile, relative to the ball at its first and last pose. They select
// the formula for each row. The choice must not depend on the vector width, so Classify makes it
// for all 16 lanes of a row together.
struct RowClasses {
  // The row's offset along v from the ball's centre: at s = 0 (v), and at the last pose (v1).
  alignas(64) float v[kTileSide], v1[kTileSide];
  // R^2 minus the square of the offset along v: at the first pose (rest0), and at the last pose
  // (rest1).
  alignas(64) float rest0[kTileSide], rest1[kTileSide];
  // The next members have one bit for each row. `live`: some lane may meet the ball at the last
  // pose.
  unsigned live;
  unsigned near;  // some lane may meet the sweep
  unsigned old;   // on all lanes, both ends belong to the first pose
  unsigned last;  // on all lanes, both ends belong to the last pose
  // On all lanes, the squared half chord is at least View::overlap at both poses.
  unsigned deep;
};

HWY_INLINE void Classify(const SweptBall::View& k, float u_base, float v_base, RowClasses& rows) {
  const DF d;
  // The table shows when an end of the sweep belongs to the last or the first pose. w is the ray's
  // offset in the (u, v) plane from the ball's centre at that pose, and dot = w.p (p: see ball.h).
  // q is the half chord at that pose, and md is the depth component of the motion.
  //
  //           last pose         first pose
  //   exit    md q + dot >= 0   md q + dot <= 0
  //   entry   md q <= dot       md q >= dot
  //
  // The bound q <= R allows a test of a whole row.
  const float reach = k.reach;
  const float v_first = k.motion_v * k.s_min, v_last = k.motion_v * k.s_max, u_end = u_base + 15.0f;
  const float shift0 = k.s_min * k.motion_u, shift1 = k.s_max * k.motion_u;
  const float left0 = u_base - shift0, right0 = u_end - shift0, left1 = u_base - shift1,
              right1 = u_end - shift1;
  const auto min_square = [](float left, float right) {
    return left <= 0 && right >= 0 ? 0.0f : std::min(left * left, right * right);
  };
  const float max_dot0 = std::max(left0 * k.motion_u, right0 * k.motion_u);
  const float min_dot1 = std::min(left1 * k.motion_u, right1 * k.motion_u);
  const VF r2 = F(k.radius2), zero = hn::Zero(d);
  const VF min0 = F(min_square(left0, right0)), min1 = F(min_square(left1, right1));
  const float max0 = std::max(left0 * left0, right0 * right0),
              max1 = std::max(left1 * left1, right1 * right1);
  rows.live = rows.near = rows.old = rows.last = rows.deep = 0;
  for (size_t g = 0; g < kGroups; g++) {
    const size_t at = g * kLanes;
    const VF v = LanesFrom(v_base, g), v0 = hn::Sub(v, F(v_first)), v1 = hn::Sub(v, F(v_last));
    const VF rest0 = hn::Sub(r2, hn::Mul(v0, v0)), rest1 = hn::Sub(r2, hn::Mul(v1, v1));
    hn::Store(v, d, rows.v + at);
    hn::Store(v1, d, rows.v1 + at);
    hn::Store(rest0, d, rows.rest0 + at);
    hn::Store(rest1, d, rows.rest1 + at);
    const VF deepest0 = hn::Sub(rest0, min0), deepest1 = hn::Sub(rest1, min1);
    rows.live |= Bits(hn::Gt(deepest1, zero)) << at;
    rows.near |= Bits(hn::Gt(hn::Max(deepest0, deepest1), F(-k.widening))) << at;
    rows.deep |=
        Bits(hn::Ge(hn::Min(hn::Sub(rest0, F(max0)), hn::Sub(rest1, F(max1))), F(k.overlap))) << at;
    const VF dot0 = hn::Add(F(max_dot0), hn::Mul(v0, F(k.motion_v)));
    const VF dot1 = hn::Add(F(min_dot1), hn::Mul(v1, F(k.motion_v)));
    rows.old |= Bits(hn::Le(hn::Add(dot0, F(reach)), zero)) << at;
    rows.last |= Bits(hn::Ge(dot1, F(reach))) << at;
  }
}

// Computes the intervals of a tile. In a short motion, nearly every row has both ends at the first
// pose, or both at the last pose (RowClasses). Rows with both ends at the last pose use a short
// formula. Rows with both ends at a clear first pose add nothing. All other rows use SweepEnds. A
// ball's normal is the direction from its centre to the end. Therefore, this function computes the
// normals, too.
void BallSpans(const SweptBall::View& view, float u_base, float v_base, SpanLayer& out) {
  const DF d;
  const DU du;
  const SweptBall::View k = view;  // a copy, which a store to `out` cannot change
  const float md = k.motion_d;
  RowClasses row_class;
  Classify(k, u_base, v_base, row_class);
  // With a clear first pose, a row adds nothing if both its ends belong to that pose.
  const unsigned fresh = row_class.near & (k.start_is_clear ? ~row_class.old : ~0u);
  if (!fresh) {
    out.rows = 0;
    return;
  }
  // With head_on, the ball moves nearly along the rays. In rows of `deep`, the intervals of both
  // poses overlap on each ray. The last pose has the new end. The other end of its interval is
  // inside the first pose. Therefore, the interval of the last pose is enough.
  const unsigned head_on = k.head_on ? fresh & ~row_class.deep : 0;
  const unsigned last = fresh & (k.head_on ? row_class.deep : row_class.last & row_class.live);
  const VF zero = hn::Zero(d), far = F(kFar), minus_far = F(-kFar);
  const VF centre0 = F(k.centre_depth + k.s_min * md), centre1 = F(k.centre_depth + k.s_max * md);
  const VF code_scale = F(NormalScale(out.flip) * k.code_scale);
  alignas(64) uint32_t row_code[kTileSide];
  for (size_t g = 0; g < kGroups; g++)
    hn::Store(EncodeScaled(zero, hn::Load(d, row_class.v1 + g * kLanes), code_scale), du,
              row_code + g * kLanes);
  unsigned rows = last, swept = k.head_on ? 0 : fresh & ~row_class.last;
  for (size_t g = 0; g < kGroups; g++) {
    const VF u = LanesFrom(u_base, g);
    const VF u0 = hn::Sub(u, F(k.s_min * k.motion_u)), u1 = hn::Sub(u, F(k.s_max * k.motion_u));
    const VF u0_squared = hn::Mul(u0, u0), u1_squared = hn::Mul(u1, u1);
    const VU lane_code = EncodeScaled(u1, zero, code_scale);
    for (unsigned left = last; left; left &= left - 1) {
      const auto row = static_cast<size_t>(__builtin_ctz(left));
      const size_t slot = row * kTileSide + g * kLanes;
      const VF rest1 = hn::Sub(F(row_class.rest1[row]), u1_squared);
      // If the ray misses the ball, q1 is 0, and the interval is empty.
      const VF q1 = hn::Sqrt(hn::Max(rest1, zero));
      hn::Store(hn::Sub(centre1, q1), d, out.lo + slot);
      hn::Store(hn::Add(centre1, q1), d, out.hi + slot);
      const VU code = hn::Or(lane_code, hn::Set(du, row_code[row]));
      hn::Store(code, du, out.codes.lo + slot);
      hn::Store(code, du, out.codes.hi + slot);
    }
    for (unsigned left = head_on; left; left &= left - 1) {
      // The sweep has one new end, at the last pose. The other end may be anywhere inside the clear
      // first pose, so it is put at the depth of the centre.
      const auto row = static_cast<size_t>(__builtin_ctz(left));
      const size_t slot = row * kTileSide + g * kLanes;
      const VF rest0 = hn::Sub(F(row_class.rest0[row]), u0_squared);
      const VF rest1 = hn::Sub(F(row_class.rest1[row]), u1_squared);
      const VF q1 = hn::Sqrt(hn::Max(rest1, zero));
      const MF live = hn::Ge(hn::Min(rest0, rest1), F(k.rim));
      const VF end = md > 0 ? hn::Add(centre1, q1) : hn::Sub(centre1, q1);
      const VF shut = hn::IfThenElse(live, end, md > 0 ? minus_far : far);
      hn::Store(md > 0 ? centre0 : shut, d, out.lo + slot);
      hn::Store(md > 0 ? shut : centre0, d, out.hi + slot);
      const VU code = hn::Or(lane_code, hn::Set(du, row_code[row]));
      hn::Store(code, du, out.codes.lo + slot);
      hn::Store(code, du, out.codes.hi + slot);
      const bool unsure = !hn::AllFalse(d, hn::AndNot(live, hn::Gt(rest1, F(-k.widening))));
      swept |= static_cast<unsigned>(unsure) << row;
      rows |= static_cast<unsigned>(!hn::AllFalse(d, live)) << row;
    }
  }
  rows &= ~swept;
  for (size_t g = 0; g < kGroups; g++) {
    for (unsigned left = swept; left; left &= left - 1) {
      const auto row = static_cast<size_t>(__builtin_ctz(left));
      const size_t slot = row * kTileSide + g * kLanes;
      const Ends ends = SweepEnds(k, LanesFrom(u_base, g), row_class.v[row], code_scale);
      MF live = hn::And(ends.live, hn::Lt(ends.lo, ends.hi));
      if (k.start_is_clear) live = hn::AndNot(ends.old, live);
      hn::Store(hn::IfThenElse(live, ends.lo, far), d, out.lo + slot);
      hn::Store(hn::IfThenElse(live, ends.hi, minus_far), d, out.hi + slot);
      hn::Store(ends.code_lo, du, out.codes.lo + slot);
      hn::Store(ends.code_hi, du, out.codes.hi + slot);
      rows |= static_cast<unsigned>(!hn::AllFalse(d, live)) << row;
    }
  }
  out.rows = out.normals_ready = static_cast<uint16_t>(rows);
}

}  // namespace HWY_NAMESPACE
}  // namespace kibori
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kibori {
HWY_EXPORT(BallSpans);

// Slack for float32 rounding in the bounds of View. The relative part is kWider. The absolute part
// is kWider2 for squares [lattice units^2], and kReachSlack for products with a motion. With
// smaller values, a ray at a tool's rim may get an end from the wrong formula. With larger values,
// more rays use the slower formula.
constexpr double kWider = 1.001, kWider2 = 1e-3, kReachSlack = 1e-5;
// Normals are scaled to this length before they are encoded. It is below 1, so that rounding does
// not produce a component above 1.
constexpr double kInUnit = 0.9999;
// View::shift for a motion along the rays. It is so large that the clamp always selects an end
// pose.
constexpr double kBeyondClamp = 1e10;

SweptBall::SweptBall(const LatticePoint& centre, const LatticeVector& motion, double radius,
                     bool start_is_clear)
    : centre_(centre.units), motion_(motion.units), radius_(radius) {
  const double length2 = motion_.squaredNorm(), length = std::sqrt(length2);
  recentre_ = length > kRecentreLength;
  choose_vector_unit();
  kernel_ = HWY_DYNAMIC_DISPATCH(BallSpans);
  for (Axis axis : kAxes) {
    View& k = views_[static_cast<size_t>(axis)];
    const double mu = motion[u_index(axis)], mv = motion[v_index(axis)],
                 md = motion[depth_index(axis)];
    k.centre_u = centre[u_index(axis)];
    k.centre_v = centre[v_index(axis)];
    k.centre_d = centre[depth_index(axis)];
    const double flat2 = mu * mu + mv * mv, flat = std::sqrt(flat2);
    const bool has_flat = flat2 > kNoSweep * kNoSweep;
    k.along_u = has_flat ? mu / flat2 : 0;
    k.along_v = has_flat ? mv / flat2 : 0;
    k.motion_u = static_cast<float>(mu);
    k.motion_v = static_cast<float>(mv);
    k.motion_d = static_cast<float>(md);
    k.step_u = static_cast<float>(k.along_u);
    k.step_v = static_cast<float>(k.along_v);
    k.normal_u = static_cast<float>(has_flat ? mu / flat : 0);
    k.normal_v = static_cast<float>(has_flat ? mv / flat : 0);
    // If the motion is along the ray, each end belongs to one of the two end poses.
    k.shift = static_cast<float>(has_flat ? md / (flat * length)
                                 : md > 0 ? kBeyondClamp
                                 : md < 0 ? -kBeyondClamp
                                          : 0);
    k.radius2 = static_cast<float>(radius * radius);
    k.code_scale = static_cast<float>(kInUnit / radius);
    k.reach = static_cast<float>(std::abs(md) * radius * kWider + kReachSlack);
    k.centre_depth = static_cast<float>(k.centre_d);
    // Between the end poses, the squared half chord exceeds the one at the nearer end pose by at
    // most (R + |p|)^2 - R^2.
    k.widening = static_cast<float>((2 * radius * flat + flat2) * kWider + kWider2);
    // If the motion is nearly along the rays, an end belongs to an end pose if |md| q >= R |p|.
    // `rim` is the square of the smallest such q.
    const double rim = md != 0 ? radius * flat / md : 0;
    k.rim = static_cast<float>(rim * rim * kWider + kWider2);
    k.overlap = std::max(k.rim, static_cast<float>(0.2501 * md * md + kWider2));
    k.head_on = start_is_clear && !recentre_ && flat < 0.2 * std::abs(md);
    k.s_min = 0;
    k.s_max = 1;
    k.start_is_clear = start_is_clear;
  }
}

SweptBall::View SweptBall::view_at(const RayTile& rays) const {
  View k = views_[static_cast<size_t>(rays.axis)];
  if (recentre_) {
    const double half = 0.5 * kTileSide;
    const double s = std::clamp(
        (rays.u0 + half - k.centre_u) * k.along_u + (rays.v0 + half - k.centre_v) * k.along_v, 0.0,
        1.0);
    k.centre_u += s * motion_[u_index(rays.axis)];
    k.centre_v += s * motion_[v_index(rays.axis)];
    k.centre_d += s * motion_[depth_index(rays.axis)];
    k.centre_depth = static_cast<float>(k.centre_d);
    k.s_min = static_cast<float>(-s);
    k.s_max = static_cast<float>(1 - s);
  }
  return k;
}

LatticeBox SweptBall::bounds() const {
  Box box;
  box.include(centre_);
  box.include(Vec3(centre_ + motion_));
  return {box.grown(radius_)};
}

bool SweptBall::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  if (layer != 0) return false;
  out.last = true;
  const auto run = [&](const View& k) {
    kernel_(k, static_cast<float>(rays.u0 + 0.5 - k.centre_u),
            static_cast<float>(rays.v0 + 0.5 - k.centre_v), out);
  };
  if (recentre_)
    run(view_at(rays));
  else
    run(views_[static_cast<size_t>(rays.axis)]);
  return out.rows != 0;
}

}  // namespace kibori
#endif
