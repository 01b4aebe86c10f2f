// SPDX-License-Identifier: MIT
#include <kibori/solid/ball.h>

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kibori/solid/ball.cpp"
#include <hwy/foreach_target.h>
#include <kibori/base/lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kibori {
namespace HWY_NAMESPACE {

// The ends where the ball passes through the ray between its end poses: the formula of ball.h.
struct Ends {
  VF lo, hi;
  MF live;
};
HWY_INLINE Ends BetweenPoses(const SweptBall::View& k, VF u, float v_row) {
  const DF d;
  const VF r2 = F(k.radius * k.radius), s_min = F(k.s_min), s_max = F(k.s_max), v = F(v_row);
  const VF s0 = hn::Add(hn::Mul(u, F(k.step_u)), F(v_row * k.step_v));
  const VF across = hn::Sub(hn::Mul(u, F(k.normal_v)), F(v_row * k.normal_u));
  const VF m = hn::Sub(r2, hn::Mul(across, across));
  const VF turn = hn::Mul(hn::Mul(m, RoughRsqrt(hn::Max(m, F(1e-30f)))), F(k.shift));
  const auto end = [&](VF s, VF& rem) HWY_ATTR {
    s = hn::Min(hn::Max(s, s_min), s_max);
    const VF du = hn::Sub(u, hn::Mul(s, F(k.motion_u))), dv = hn::Sub(v, hn::Mul(s, F(k.motion_v)));
    rem = hn::Sub(hn::Sub(r2, hn::Mul(du, du)), hn::Mul(dv, dv));
    return hn::Mul(s, F(k.motion_d));
  };
  VF rem_lo, rem_hi;
  const VF at_lo = end(hn::Sub(s0, turn), rem_lo), at_hi = end(hn::Add(s0, turn), rem_hi);
  const VF zero = hn::Zero(d);
  Ends ends;
  ends.live = hn::And(hn::Gt(m, zero), hn::And(hn::Gt(rem_lo, zero), hn::Gt(rem_hi, zero)));
  ends.lo = hn::Sub(at_lo, hn::Sqrt(hn::Max(rem_lo, zero)));
  ends.hi = hn::Add(at_hi, hn::Sqrt(hn::Max(rem_hi, zero)));
  return ends;
}

// In short motions nearly every end belongs to one of the end poses. With w the ray's offset from the ball's
// centre there, dot = w.p and q = half the chord, the exit belongs to the last pose where md q + dot >= 0 and
// to the first where md q + dot <= 0; the entry where md q <= dot and md q >= dot. `open` collects the other
// lanes, by row; they take BetweenPoses in a second pass. Which way a lane takes depends on that lane alone,
// never on its neighbours, so the vector's width does not show.
void BallSpans(const SweptBall::View& k, float u_base, float v_base, SpanLayer& out) {
  const DF d;
  const float r2 = k.radius * k.radius, md = k.motion_d, md2 = md * md;
  const float v_first = k.motion_v * k.s_min, v_last = k.motion_v * k.s_max;
  // Rows the sweep's shadow can touch; one row of slack against rounding.
  const float lowest = std::min(v_first, v_last) - k.radius - v_base - 1;
  const float highest = std::max(v_first, v_last) + k.radius - v_base + 1;
  const int row_begin = static_cast<int>(std::clamp(lowest, 0.0f, 16.0f));
  const int row_end = static_cast<int>(std::clamp(highest + 1, 0.0f, 16.0f));
  const float reach = std::abs(md) * k.radius * 1.001f + 1e-5f;
  const VF zero = hn::Zero(d), far = F(kFar), minus_far = F(-kFar);
  const VF centre = F(static_cast<float>(k.centre_d));
  const VF centre0 = hn::Add(centre, F(k.s_min * md)), centre1 = hn::Add(centre, F(k.s_max * md));
  unsigned rows = 0;
  for (size_t g = 0; g < kGroups; g++) {
    const float u_left = u_base + static_cast<float>(g * kLanes);
    const VF u = LanesFrom(u_base, g);
    const VF u0 = hn::Sub(u, F(k.s_min * k.motion_u)), u1 = hn::Sub(u, F(k.s_max * k.motion_u));
    const VF u0_squared = hn::Mul(u0, u0), u1_squared = hn::Mul(u1, u1);
    const VF u0_dot = hn::Mul(u0, F(k.motion_u)), u1_dot = hn::Mul(u1, F(k.motion_u));
    // Over all lanes, dot0 is at most and dot1 at least this plus the row's part.
    const float width = static_cast<float>(kLanes - 1) * k.motion_u;
    const float dot0_most = (u_left - k.s_min * k.motion_u) * k.motion_u + std::max(0.0f, width);
    const float dot1_least = (u_left - k.s_max * k.motion_u) * k.motion_u + std::min(0.0f, width);
    uint16_t open_rows[kTileSide];
    unsigned open_any = 0;
    for (int row = row_begin; row < row_end; row++) {
      const float v = v_base + static_cast<float>(row);
      const float v0 = v - v_first, v1 = v - v_last;
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      // A clear start pose: where both ends still belong to it, the sweep brings nothing new.
      if (k.start_is_clear && dot0_most + v0 * k.motion_v + reach <= 0) {
        if (kGroups > 1) {
          hn::Store(far, d, out.lo + slot);
          hn::Store(minus_far, d, out.hi + slot);
        }
        open_rows[row] = 0;
        continue;
      }
      const VF rem1 = hn::Sub(F(r2 - v1 * v1), u1_squared);
      const VF q1 = hn::Sqrt(hn::Max(rem1, zero));
      VF t_lo = hn::Sub(centre1, q1), t_hi = hn::Add(centre1, q1);
      MF live;
      unsigned open = 0;
      if (k.head_on) {
        // Moving along the rays from a clear start: one end is new, the other anywhere inside the start pose.
        const VF rem0 = hn::Sub(F(r2 - v0 * v0), u0_squared);
        const VF least = hn::Min(rem0, rem1);
        live = hn::Ge(least, F(k.rim));
        open = Bits(hn::AndNot(live, hn::Gt(rem1, F(-k.widening))));
        if (md > 0)
          t_lo = centre0;
        else
          t_hi = centre0;
      } else if (dot1_least + v1 * k.motion_v >= reach) {
        // The whole row has the ball's last pose nearest.
        live = hn::Gt(rem1, zero);
      } else {
        const VF rem0 = hn::Sub(F(r2 - v0 * v0), u0_squared);
        const VF dot0 = hn::Add(u0_dot, F(v0 * k.motion_v)), dot1 = hn::Add(u1_dot, F(v1 * k.motion_v));
        const VF mq1 = hn::Mul(q1, F(md));
        const MF lo1 = hn::Le(mq1, dot1), hi1 = hn::Ge(hn::Add(mq1, dot1), zero);
        // dot0 <= +|md| q0 and dot0 <= -|md| q0, without the root.
        const VF dot0_squared = hn::Mul(dot0, dot0), bound = hn::Mul(hn::Max(rem0, zero), F(md2));
        const MF negative = hn::Le(dot0, zero);
        const MF weak = hn::Or(negative, hn::Le(dot0_squared, bound));
        const MF strong = hn::And(negative, hn::Ge(dot0_squared, bound));
        const MF lo0 = md >= 0 ? weak : strong, hi0 = md >= 0 ? strong : weak;
        const MF in1 = hn::Gt(rem1, zero), in0 = hn::Gt(rem0, zero);
        const MF settled = hn::And(hn::Or(lo0, lo1), hn::Or(hi0, hi1));
        const MF maybe = hn::Gt(hn::Max(rem0, rem1), F(-k.widening));
        live = hn::And(settled, hn::And(hn::Or(hn::And(lo1, in1), hn::AndNot(lo1, in0)),
                                        hn::Or(hn::And(hi1, in1), hn::AndNot(hi1, in0))));
        MF between = hn::AndNot(settled, maybe);
        VF start_lo = centre0, start_hi = centre0;  // clear: any depth inside will do
        if (k.start_is_clear) {
          const MF old = hn::And(lo0, hi0);
          live = hn::AndNot(old, live);
          between = hn::AndNot(old, between);
        } else {
          const VF q0 = hn::Sqrt(hn::Max(rem0, zero));
          start_lo = hn::Sub(centre0, q0);
          start_hi = hn::Add(centre0, q0);
        }
        t_lo = hn::IfThenElse(lo1, t_lo, start_lo);
        t_hi = hn::IfThenElse(hi1, t_hi, start_hi);
        open = Bits(between);
      }
      live = hn::And(live, hn::Lt(t_lo, t_hi));
      hn::Store(hn::IfThenElse(live, t_lo, far), d, out.lo + slot);
      hn::Store(hn::IfThenElse(live, t_hi, minus_far), d, out.hi + slot);
      rows |= static_cast<unsigned>(!hn::AllFalse(d, live)) << row;
      open_rows[row] = static_cast<uint16_t>(open);
      open_any |= open;
    }
    if (!open_any) continue;
    for (int row = row_begin; row < row_end; row++) {
      if (!open_rows[row]) continue;
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      const MF open = FromBits(open_rows[row]);
      const Ends ends = BetweenPoses(k, u, v_base + static_cast<float>(row));
      const VF t_lo = hn::Add(centre, ends.lo), t_hi = hn::Add(centre, ends.hi);
      const MF live = hn::And(hn::And(open, ends.live), hn::Lt(t_lo, t_hi));
      hn::BlendedStore(t_lo, live, d, out.lo + slot);
      hn::BlendedStore(t_hi, live, d, out.hi + slot);
      rows |= static_cast<unsigned>(!hn::AllFalse(d, live)) << row;
    }
  }
  if (kGroups > 1)  // a filled row is filled in all its groups
    for (int row = 0; row < kTileSide; row++)
      if (row < row_begin || row >= row_end) rows &= ~(1u << row);
  out.rows = static_cast<uint16_t>(rows);
}

void BallNormals(const SweptBall::View& k, float u_base, float v_base, const SpanLayer& spans,
                 const EndMasks& ends, NormalCodes& out) {
  const DF d;
  const DU du;
  const VF s_min = F(k.s_min), s_max = F(k.s_max), centre = F(static_cast<float>(k.centre_d));
  const VF scale = F(NormalScale(ends.flip) / k.radius * 0.9999f);
  const auto encode = [&](const float* depth, float v, size_t g, uint32_t* to) HWY_ATTR {
    const VF u = LanesFrom(u_base, g);
    const VF t = hn::Sub(hn::Load(d, depth), centre);
    // The nearest point of the path is the centre of the ball that touches here.
    VF s = hn::Add(hn::Mul(u, F(k.motion_u)), F(v * k.motion_v));
    s = hn::Mul(hn::Add(s, hn::Mul(t, F(k.motion_d))), F(k.inverse_length2));
    s = hn::Min(hn::Max(s, s_min), s_max);
    hn::Store(
        EncodeScaled(hn::Sub(u, hn::Mul(s, F(k.motion_u))), hn::Sub(F(v), hn::Mul(s, F(k.motion_v))), scale),
        du, to);
  };
  for (int row = 0; row < kTileSide; row++) {
    const float v = v_base + static_cast<float>(row);
    for (size_t g = 0; g < kGroups; g++) {
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      const unsigned group = kGroupMask << (g * kLanes);
      if (ends.lo[row] & group) encode(spans.lo + slot, v, g, out.lo + slot);
      if (ends.hi[row] & group) encode(spans.hi + slot, v, g, out.hi + slot);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kibori
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kibori {
HWY_EXPORT(BallSpans);
HWY_EXPORT(BallNormals);

SweptBall::SweptBall(const Vec3& centre, const Vec3& motion, double radius, bool start_is_clear)
    : centre_(centre), motion_(motion), radius_(radius) {
  const double length2 = motion.squaredNorm(), length = std::sqrt(length2);
  recentre_ = length > kRecentreLength;
  for (Axis axis : kAxes) {
    View& k = views_[static_cast<size_t>(axis)];
    const double mu = motion[u_index(axis)], mv = motion[v_index(axis)], md = motion[depth_index(axis)];
    k.centre_u = centre[u_index(axis)];
    k.centre_v = centre[v_index(axis)];
    k.centre_d = centre[depth_index(axis)];
    const double flat2 = mu * mu + mv * mv, flat = std::sqrt(flat2);
    const bool has_flat = flat2 > 1e-24;
    k.along_u = has_flat ? mu / flat2 : 0;
    k.along_v = has_flat ? mv / flat2 : 0;
    k.motion_u = static_cast<float>(mu);
    k.motion_v = static_cast<float>(mv);
    k.motion_d = static_cast<float>(md);
    k.step_u = static_cast<float>(k.along_u);
    k.step_v = static_cast<float>(k.along_v);
    k.normal_u = static_cast<float>(has_flat ? mu / flat : 0);
    k.normal_v = static_cast<float>(has_flat ? mv / flat : 0);
    // Along the ray the ends belong to the two end poses outright: a shift no clamp can miss.
    k.shift = static_cast<float>(has_flat ? md / (flat * length) : md > 0 ? 1e10 : md < 0 ? -1e10 : 0);
    k.inverse_length2 = static_cast<float>(length2 > 1e-24 ? 1 / length2 : 0);
    k.radius = static_cast<float>(radius);
    // Between the poses the squared half chord is at most this much larger than at the nearer one: (R +
    // |p|)^2 - R^2.
    k.widening = static_cast<float>((2 * radius * flat + flat2) * 1.001 + 1e-3);
    // Moving along the rays, an end belongs to its pose for sure where md q >= R |p|: squared half chords
    // from here up.
    const double rim = md != 0 ? radius * flat / md : 0;
    k.rim = static_cast<float>(rim * rim * 1.001 + 1e-3);
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
        (rays.u0 + half - k.centre_u) * k.along_u + (rays.v0 + half - k.centre_v) * k.along_v, 0.0, 1.0);
    k.centre_u += s * motion_[u_index(rays.axis)];
    k.centre_v += s * motion_[v_index(rays.axis)];
    k.centre_d += s * motion_[depth_index(rays.axis)];
    k.s_min = static_cast<float>(-s);
    k.s_max = static_cast<float>(1 - s);
  }
  return k;
}

Box SweptBall::bounds() const {
  Box box;
  box.include(centre_);
  box.include(Vec3(centre_ + motion_));
  return box.grown(radius_);
}

bool SweptBall::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  if (layer != 0) return false;
  const View k = view_at(rays);
  HWY_DYNAMIC_DISPATCH(BallSpans)
  (k, static_cast<float>(rays.u0 + 0.5 - k.centre_u), static_cast<float>(rays.v0 + 0.5 - k.centre_v), out);
  return out.rows != 0;
}

void SweptBall::normals(const RayTile& rays, int, const SpanLayer& spans, const EndMasks& ends,
                        NormalCodes& out) const {
  const View k = view_at(rays);
  HWY_DYNAMIC_DISPATCH(BallNormals)
  (k, static_cast<float>(rays.u0 + 0.5 - k.centre_u), static_cast<float>(rays.v0 + 0.5 - k.centre_v), spans,
   ends, out);
}

}  // namespace kibori
#endif
