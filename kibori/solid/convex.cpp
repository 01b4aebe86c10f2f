// SPDX-License-Identifier: MIT
#include <kibori/solid/convex.h>

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kibori/solid/convex.cpp"
#include <hwy/foreach_target.h>
#include <kibori/base/lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kibori {
namespace HWY_NAMESPACE {

// If a plane's depth changes by less than this per lattice unit along a line, the two are parallel.
// The plane then clips the line nowhere or everywhere. Unit normals have float32 rounding of 1e-7,
// so no plane is below this by chance. With a larger value, the solver would ignore faces that do
// clip the line. With a smaller one, their bounds would overflow.
constexpr float kParallel = 1e-12f;
// Curvature [1/lattice unit^2] that replaces zero, so that a quadratic always has two roots. The
// second root is then near infinity. If it is smaller, its product with an offset underflows.
constexpr float kNoCurve = 1e-18f;
// Minimum of the discriminant. Its root prevents 0 / 0 in c / w where a ray only touches the
// quadric. A value near one cell^2 would be visible.
constexpr float kMinDiscriminant = 1e-36f;
// If a quadric curves less along the motion than this [1/lattice unit^2], it has no silhouette.
constexpr float kNoSilhouette = 1e-20f;
// A ray is steep to a face if the sine of their angle exceeds this.
constexpr float kSteep = 0.5f;
// Tolerance for a point on the wrong side of a cone's apex, relative to its coordinates in the
// tool's frame. It is the float32 rounding (2^-24) of some five terms. If it is smaller, a ray that
// meets the apex's path loses its end. If it is larger, the sweep is longer there by that amount.
constexpr float kApexRounding = 1e-6f;

struct Interval {
  VF lo, hi;
};

// The one interval of the convex body in which a x^2 + 2 b x + c >= 0. `a` is the same for all
// lanes. If a < 0 (always for a concave quadric), it is between the roots. If a > 0 (cone), it is
// on one side of them, above if `upward`.
HWY_INLINE Interval Solve(float a, VF b, VF c, bool cone, bool upward) {
  const DF d;
  if (!cone || std::abs(a) < kParallel) a = std::min(a, -kNoCurve);
  const VF va = F(a);
  const VF disc = hn::Sub(hn::Mul(b, b), hn::Mul(va, c));
  const MF real = hn::Ge(disc, hn::Zero(d));
  const VF root = hn::Sqrt(hn::Max(disc, F(kMinDiscriminant)));
  const VF w = hn::Neg(hn::Add(b, hn::CopySign(root, b)));  // no cancellation
  const VF r1 = hn::Div(w, va), r2 = hn::Div(c, w);
  const VF lo = hn::Min(r1, r2), hi = hn::Max(r1, r2);
  if (a < 0) return {hn::IfThenElse(real, lo, F(kFar)), hn::IfThenElse(real, hi, F(-kFar))};
  if (upward) return {hi, F(kFar)};
  return {F(-kFar), lo};
}

// The result of Solve for a body without a quadric.
HWY_INLINE Interval Everywhere() { return {F(-kFar), F(kFar)}; }

// Clips [lo, hi] by slope x + offset >= 0; slope is the same for all lanes.
HWY_INLINE void Clip(Interval& x, float slope, VF offset) {
  const DF d;
  if (std::abs(slope) < kParallel) {
    const MF out = hn::Lt(offset, hn::Zero(d));
    x.lo = hn::IfThenElse(out, F(kFar), x.lo);
    return;
  }
  const VF bound = hn::Mul(offset, F(-1.0f / slope));
  if (slope > 0)
    x.lo = hn::Max(x.lo, bound);
  else
    x.hi = hn::Min(x.hi, bound);
}

// Solves one row of rays. With kNormals, it also computes the outward normal at each end.
template <bool kNormals>
struct RowSolver {
  const SweptConvex::View& k;
  VF u, v;  // ray position relative to the tip
  // q(t,s) = tt t^2 + 2 ts t s + ss s^2 + 2 lin_t t + 2 lin_s s + con.
  VF lin_t, lin_s, con;
  VF plane[ConvexBody::kMaxPlanes];  // l_j at t = s = 0
  VF lo, hi;
  VF lo_nu, lo_nv, lo_nt, hi_nu, hi_nv, hi_nt;

  HWY_INLINE RowSolver(const SweptConvex::View& view, VF u_, VF v_) : k(view), u(u_), v(v_) {
    for (int j = 0; j < k.planes; j++)
      plane[j] = hn::Add(hn::Add(hn::Mul(u, F(k.nu[j])), hn::Mul(v, F(k.nv[j]))), F(k.offset[j]));
    lo = F(kFar);
    hi = F(-kFar);
    if constexpr (kNormals) lo_nu = lo_nv = lo_nt = hi_nu = hi_nv = hi_nt = hn::Zero(DF());
    if (!k.quadric) return;
    const VF two = F(2.0f);
    lin_t = hn::Add(hn::Add(hn::Mul(u, F(k.qut)), hn::Mul(v, F(k.qvt))), F(k.bt));
    lin_s = hn::Neg(hn::Add(hn::Add(hn::Mul(u, F(k.qm_u)), hn::Mul(v, F(k.qm_v))), F(k.bm)));
    const VF uu = hn::Add(hn::Add(hn::Mul(u, F(k.quu)), hn::Mul(v, hn::Mul(two, F(k.quv)))),
                          hn::Mul(two, F(k.bu)));
    const VF vv = hn::Add(hn::Mul(v, F(k.qvv)), hn::Mul(two, F(k.bv)));
    con = hn::Add(hn::Add(hn::Mul(u, uu), hn::Mul(v, vv)), F(k.c));
  }

  // The quadric's outward normal at (t, s): minus half its gradient.
  HWY_INLINE void Gradient(VF t, VF s, VF& nu, VF& nv, VF& nt) const {
    const VF x = hn::Sub(u, hn::Mul(s, F(k.mu))), y = hn::Sub(v, hn::Mul(s, F(k.mv))),
             z = hn::Sub(t, hn::Mul(s, F(k.mt)));
    const auto row = [&](float a, float b, float c, float e) HWY_ATTR {
      return hn::Neg(
          hn::Add(hn::Add(hn::Mul(x, F(a)), hn::Mul(y, F(b))), hn::Add(hn::Mul(z, F(c)), F(e))));
    };
    nu = row(k.quu, k.quv, k.qut, k.bu);
    nv = row(k.quv, k.qvv, k.qvt, k.bv);
    nt = row(k.qut, k.qvt, k.qtt, k.bt);
  }

  HWY_INLINE void OfferQuadric(MF valid, VF t, VF s, bool for_lo, bool for_hi) {
    VF nu, nv, nt;
    if constexpr (kNormals) Gradient(t, s, nu, nv, nt);
    Offer(valid, t, for_lo, for_hi, nu, nv, nt);
  }
  HWY_INLINE void OfferPlane(MF valid, VF t, int j, bool for_lo, bool for_hi) {
    Offer(valid, t, for_lo, for_hi, F(-k.nu[j]), F(-k.nv[j]), F(-k.nt[j]));
  }
  HWY_INLINE void Offer(MF valid, VF t, bool for_lo, bool for_hi, VF nu, VF nv, VF nt) {
    if (for_lo) {
      const MF better = hn::And(valid, hn::Lt(t, lo));
      lo = hn::IfThenElse(better, t, lo);
      if constexpr (kNormals) {
        lo_nu = hn::IfThenElse(better, nu, lo_nu);
        lo_nv = hn::IfThenElse(better, nv, lo_nv);
        lo_nt = hn::IfThenElse(better, nt, lo_nt);
      }
    }
    if (for_hi) {
      const MF better = hn::And(valid, hn::Gt(t, hi));
      hi = hn::IfThenElse(better, t, hi);
      if constexpr (kNormals) {
        hi_nu = hn::IfThenElse(better, nu, hi_nu);
        hi_nv = hn::IfThenElse(better, nv, hi_nv);
        hi_nt = hn::IfThenElse(better, nt, hi_nt);
      }
    }
  }

  // A point of the swept rim where faces g and p meet. Its normal is the combination of their
  // normals that is perpendicular to the motion.
  HWY_INLINE void OfferRim(MF valid, VF t, VF gu, VF gv, VF gt, int j, bool for_lo, bool for_hi) {
    const VF pu = F(-k.nu[j]), pv = F(-k.nv[j]), pt = F(-k.nt[j]);
    const VF gm =
        hn::Abs(hn::Add(hn::Add(hn::Mul(gu, F(k.mu)), hn::Mul(gv, F(k.mv))), hn::Mul(gt, F(k.mt))));
    const VF pm = F(std::abs(k.slope[j]));
    Offer(valid, t, for_lo, for_hi, hn::Add(hn::Mul(pm, gu), hn::Mul(gm, pu)),
          hn::Add(hn::Mul(pm, gv), hn::Mul(gm, pv)), hn::Add(hn::Mul(pm, gt), hn::Mul(gm, pt)));
  }

  // The end poses: the ray against the body at a fixed s.
  HWY_INLINE void AtPose(float s) {
    const DF d;
    const VF vs = F(s);
    // For a cone, the origin is its apex at that pose, and depths start at `base`. A ray that
    // passes close to the apex has a very short interval. With another origin, rounding would be
    // larger than this interval.
    const VF base = F(k.cone ? s * k.mt : 0.0f);
    VF b = hn::Zero(d), c = hn::Zero(d);
    if (k.cone) {
      const VF pu = hn::Sub(u, F(s * k.mu)), pv = hn::Sub(v, F(s * k.mv));
      b = hn::Add(hn::Mul(pu, F(k.qut)), hn::Mul(pv, F(k.qvt)));
      c = hn::Add(hn::Mul(pu, hn::Add(hn::Mul(pu, F(k.quu)), hn::Mul(pv, F(2 * k.quv)))),
                  hn::Mul(hn::Mul(pv, pv), F(k.qvv)));
    } else if (k.quadric) {
      b = hn::Add(lin_t, F(k.ts * s));
      c = hn::Add(con, hn::Mul(vs, hn::Add(hn::Mul(F(2.0f), lin_s), F(k.ss * s))));
    }
    Interval x = k.quadric ? Solve(k.tt, b, c, k.cone, k.cone && k.nt[0] > 0) : Everywhere();
    x.lo = hn::Add(x.lo, base);
    x.hi = hn::Add(x.hi, base);
    const Interval quadric = x;
    VF at[ConvexBody::kMaxPlanes];
    for (int j = 0; j < k.planes; j++) {
      at[j] = hn::Add(plane[j], F(k.slope[j] * s));
      Clip(x, k.nt[j], at[j]);
    }
    const MF valid = hn::Lt(x.lo, x.hi);
    if (hn::AllFalse(d, valid)) return;
    if constexpr (!kNormals) {
      Offer(valid, x.lo, true, false, lo, lo, lo);
      Offer(valid, x.hi, false, true, lo, lo, lo);
    } else {
      OfferQuadric(hn::And(valid, hn::Eq(x.lo, quadric.lo)), x.lo, vs, true, false);
      OfferQuadric(hn::And(valid, hn::Eq(x.hi, quadric.hi)), x.hi, vs, false, true);
      for (int j = 0; j < k.planes; j++) {
        if (std::abs(k.nt[j]) < kParallel) continue;
        const VF bound = hn::Mul(at[j], F(-1.0f / k.nt[j]));
        OfferPlane(hn::And(valid, hn::Eq(x.lo, bound)), bound, j, true, false);
        OfferPlane(hn::And(valid, hn::Eq(x.hi, bound)), bound, j, false, true);
      }
    }
  }

  // Offers the ends of the line l_j = 0 of the (t, s) plane: the swept rim of face j.
  HWY_INLINE void OnPlane(int j) {
    const DF d;
    const float alpha = k.nt[j], beta = k.slope[j];
    if (std::max(std::abs(alpha), std::abs(beta)) < kParallel) return;
    // The parameter of the line is s if |alpha| >= |beta|, otherwise t. With a quadric, it is also
    // s if the ray is steep to the face and runs along the body. With t, values high above the tip
    // would cancel.
    const bool by_s = std::abs(alpha) >= std::abs(beta) ||
                      (k.quadric && std::abs(alpha) > kSteep &&
                       std::abs(k.tt) * beta * beta < std::abs(k.ss) * alpha * alpha);
    // x is s or t; the other is other0 + step x.
    const VF other0 = hn::Mul(plane[j], F(by_s ? -1.0f / alpha : -1.0f / beta));
    const float step = by_s ? -beta / alpha : -alpha / beta;
    Interval x;
    if (!k.quadric) {
      x = Everywhere();
    } else if (by_s) {
      const float a = k.tt * step * step + 2 * k.ts * step + k.ss;
      const VF b =
          hn::Add(hn::Add(hn::Mul(other0, F(k.tt * step + k.ts)), hn::Mul(lin_t, F(step))), lin_s);
      const VF c =
          hn::Add(hn::Mul(other0, hn::Add(hn::Mul(other0, F(k.tt)), hn::Mul(F(2.0f), lin_t))), con);
      x = Solve(a, b, c, k.cone, k.cone && k.slope[0] + k.nt[0] * step > 0);
    } else {
      const float a = k.tt + 2 * k.ts * step + k.ss * step * step;
      const VF b =
          hn::Add(hn::Add(hn::Mul(other0, F(k.ts + k.ss * step)), hn::Mul(lin_s, F(step))), lin_t);
      const VF c =
          hn::Add(hn::Mul(other0, hn::Add(hn::Mul(other0, F(k.ss)), hn::Mul(F(2.0f), lin_s))), con);
      x = Solve(a, b, c, k.cone, k.cone && k.nt[0] + k.slope[0] * step > 0);
    }
    const Interval quadric = x;
    for (int i = 0; i < k.planes; i++) {
      if (i == j) continue;
      const float slope = by_s ? k.slope[i] + k.nt[i] * step : k.nt[i] + k.slope[i] * step;
      const VF offset = hn::Add(plane[i], hn::Mul(other0, F(by_s ? k.nt[i] : k.slope[i])));
      Clip(x, slope, offset);
    }
    if (by_s) {
      x.lo = hn::Max(x.lo, F(k.s_min));
      x.hi = hn::Min(x.hi, F(k.s_max));
    } else {
      Clip(x, step, hn::Sub(other0, F(k.s_min)));
      Clip(x, -step, hn::Sub(F(k.s_max), other0));
    }
    const MF valid = hn::Le(x.lo, x.hi);
    if (hn::AllFalse(d, valid)) return;
    const VF t0 = by_s ? hn::Add(other0, hn::Mul(x.lo, F(step))) : x.lo;
    const VF t1 = by_s ? hn::Add(other0, hn::Mul(x.hi, F(step))) : x.hi;
    if constexpr (!kNormals) {
      Offer(valid, t0, true, true, lo, lo, lo);
      Offer(valid, t1, true, true, lo, lo, lo);
    } else {
      const auto offer = [&](VF x_end, VF x_quadric, VF t, bool low) HWY_ATTR {
        const VF s = by_s ? x_end : hn::Add(other0, hn::Mul(x_end, F(step)));
        const MF by_quadric = hn::And(valid, hn::Eq(x_end, x_quadric));
        VF gu, gv, gt;
        Gradient(t, s, gu, gv, gt);
        OfferRim(by_quadric, t, gu, gv, gt, j, true, true);
        MF rest = hn::AndNot(by_quadric, valid);
        for (int i = 0; i < k.planes; i++) {
          if (i == j || i < k.first_face) continue;
          const float slope = by_s ? k.slope[i] + k.nt[i] * step : k.nt[i] + k.slope[i] * step;
          if (std::abs(slope) < kParallel || (slope > 0) != low) continue;
          const VF offset = hn::Add(plane[i], hn::Mul(other0, F(by_s ? k.nt[i] : k.slope[i])));
          const MF by_plane = hn::And(rest, hn::Eq(x_end, hn::Mul(offset, F(-1.0f / slope))));
          OfferRim(by_plane, t, F(-k.nu[i]), F(-k.nv[i]), F(-k.nt[i]), j, true, true);
          rest = hn::AndNot(by_plane, rest);
        }
        OfferPlane(rest, t, j, true, true);
      };
      offer(x.lo, quadric.lo, t0, true);
      offer(x.hi, quadric.hi, t1, false);
    }
  }

  // A cone's silhouettes are two planes through the apex's path, one on each side. Near that
  // path the two are almost equal. Their plane equations stay exact there, but a quadratic for both
  // would lose digits.
  HWY_INLINE void AtConeTangents() {
    const DF d;
    const VF from = hn::Add(hn::Abs(u), hn::Abs(v));
    for (const SweptConvex::View::Tangent& tangent : k.tangents) {
      if (tangent.nt == 0) continue;
      const VF t = hn::Add(hn::Mul(u, F(tangent.t_by_u)), hn::Mul(v, F(tangent.t_by_v)));
      const VF s = hn::Mul(hn::Add(hn::Mul(t, F(k.ts)), lin_s), F(-1.0f / k.ss));
      MF valid = hn::And(hn::Ge(s, F(k.s_min)), hn::Le(s, F(k.s_max)));
      for (int j = 0; j < k.planes; j++) {
        const VF value =
            hn::Add(plane[j], hn::Add(hn::Mul(t, F(k.nt[j])), hn::Mul(s, F(k.slope[j]))));
        const VF min_value =
            j < k.first_face ? hn::Mul(hn::Add(from, hn::Abs(t)), F(-kApexRounding)) : hn::Zero(d);
        valid = hn::And(valid, hn::Ge(value, min_value));
      }
      Offer(valid, t, true, true, F(tangent.nu), F(tangent.nv), F(tangent.nt));
    }
  }

  // Silhouettes: points of q = 0 where dq/ds = 0.
  HWY_INLINE void AtTangents() {
    const DF d;
    if (!(k.ss < -kNoSilhouette)) return;
    if (k.cone) return AtConeTangents();
    const float inverse = 1.0f / k.ss;
    const float a = k.tt - k.ts * k.ts * inverse;
    const VF b = hn::Sub(lin_t, hn::Mul(lin_s, F(k.ts * inverse)));
    const VF c = hn::Sub(con, hn::Mul(hn::Mul(lin_s, lin_s), F(inverse)));
    // Both roots are needed for either sign of a.
    const float safe = std::abs(a) < kNoCurve ? -kNoCurve : a;
    const VF disc = hn::Sub(hn::Mul(b, b), hn::Mul(F(safe), c));
    const MF real = hn::Ge(disc, hn::Zero(d));
    if (hn::AllFalse(d, real)) return;
    const VF root = hn::Sqrt(hn::Max(disc, F(kMinDiscriminant)));
    const VF w = hn::Neg(hn::Add(b, hn::CopySign(root, b)));
    for (const VF t : {hn::Div(w, F(safe)), hn::Div(c, w)}) {
      const VF s = hn::Mul(hn::Add(hn::Mul(t, F(k.ts)), lin_s), F(-inverse));
      MF valid = hn::And(real, hn::And(hn::Ge(s, F(k.s_min)), hn::Le(s, F(k.s_max))));
      for (int j = 0; j < k.planes; j++) {
        const VF value =
            hn::Add(plane[j], hn::Add(hn::Mul(t, F(k.nt[j])), hn::Mul(s, F(k.slope[j]))));
        valid = hn::And(valid, hn::Ge(value, hn::Zero(d)));
      }
      if (!hn::AllFalse(d, valid)) OfferQuadric(valid, t, s, true, true);
    }
  }

  HWY_INLINE void Run() {
    AtPose(k.s_min);
    if (!k.moving) return;
    AtPose(k.s_max);
    AtTangents();
    for (int j = k.first_face; j < k.planes; j++) OnPlane(j);
  }
};

// Solves rows row_begin ... row_end - 1. The solid does not reach the other rows.
void ConvexSpans(const SweptConvex::View& k, float u_base, float v_base, int row_begin, int row_end,
                 SpanLayer& out) {
  const DF d;
  const VF depth = F(static_cast<float>(k.tip_d));
  unsigned rows = 0;
  for (size_t g = 0; g < kGroups; g++) {
    const VF u = LanesFrom(u_base, g);
    for (int row = row_begin; row < row_end; row++) {
      RowSolver<false> solver(k, u, F(v_base + static_cast<float>(row)));
      solver.Run();
      const MF live = hn::Lt(solver.lo, solver.hi);
      if (!hn::AllFalse(d, live)) rows |= 1u << row;
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      hn::Store(hn::IfThenElse(live, hn::Add(solver.lo, depth), F(kFar)), d, out.lo + slot);
      hn::Store(hn::IfThenElse(live, hn::Add(solver.hi, depth), F(-kFar)), d, out.hi + slot);
    }
  }
  out.rows = static_cast<uint16_t>(rows);
}

void ConvexNormals(const SweptConvex::View& k, float u_base, float v_base, const EndMasks& ends,
                   SpanLayer& of) {
  const DU du;
  const float scale = NormalScale(of.flip);
  for (unsigned left = ends.rows; left; left &= left - 1) {
    const int row = __builtin_ctz(left);
    for (size_t g = 0; g < kGroups; g++) {
      const unsigned group = kGroupMask << (g * kLanes);
      if (!((ends.lo[row] | ends.hi[row]) & group)) continue;
      RowSolver<true> solver(k, LanesFrom(u_base, g), F(v_base + static_cast<float>(row)));
      solver.Run();
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      hn::Store(EncodeNormal(solver.lo_nu, solver.lo_nv, solver.lo_nt, scale), du,
                of.codes.lo + slot);
      hn::Store(EncodeNormal(solver.hi_nu, solver.hi_nv, solver.hi_nt, scale), du,
                of.codes.hi + slot);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kibori
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kibori {
HWY_EXPORT(ConvexSpans);
HWY_EXPORT(ConvexNormals);

void ConvexBody::add_plane(const Vec3& normal, double offset) {
  plane_normal[static_cast<size_t>(planes)] = normal;
  plane_offset[static_cast<size_t>(planes)] = offset;
  planes++;
}

ConvexBody ConvexBody::scaled(double factor) const {
  // q'(x) = q(x / factor). The planes keep their normals.
  ConvexBody result = *this;
  result.q /= factor * factor;
  result.b /= factor;
  for (int j = 0; j < planes; j++) result.plane_offset[static_cast<size_t>(j)] *= factor;
  result.local_bounds = {local_bounds.min * factor, local_bounds.max * factor};
  result.rod_thickness *= factor;
  result.rod_top *= factor;
  return result;
}

namespace {

// Two planes touch the cone x'Qx >= 0 about `axis` along a ruling and contain the motion. Returns
// their outward normals. Precondition: the motion leads out of the cone.
std::array<Vec3, 2> cone_tangents(const Mat3& q, const Vec3& axis, const Vec3& motion) {
  // The rulings are where x'Qx = 0 and x'Q motion = 0.
  const Vec3 conjugate = (q * motion).normalized();
  const Vec3 across = conjugate.cross(axis).normalized();
  Vec3 along = conjugate.cross(across);
  if (along.dot(axis) < 0) along = -along;
  const double width = std::sqrt(std::max(0.0, -along.dot(q * along) / across.dot(q * across)));
  return {Vec3(-(q * (along + width * across)).normalized()),
          Vec3(-(q * (along - width * across)).normalized())};
}

// Sets the coefficients of one field's view. The arguments are relative to the view's origin.
void set_view(SweptConvex::View& k, Axis axis, const Mat3& q, const Vec3& b, double c,
              const Vec3& motion, int planes,
              const std::array<Vec3, ConvexBody::kMaxPlanes>& normal,
              const std::array<double, ConvexBody::kMaxPlanes>& offset) {
  const int u = u_index(axis), v = v_index(axis), t = depth_index(axis);
  const auto f = [](double x) { return static_cast<float>(x); };
  k.quu = f(q(u, u));
  k.quv = f(q(u, v));
  k.qvv = f(q(v, v));
  k.qut = f(q(u, t));
  k.qvt = f(q(v, t));
  k.qtt = f(q(t, t));
  k.bu = f(b[u]);
  k.bv = f(b[v]);
  k.bt = f(b[t]);
  k.c = f(c);
  k.mu = f(motion[u]);
  k.mv = f(motion[v]);
  k.mt = f(motion[t]);
  const Vec3 qm = q * motion;
  k.qm_u = f(qm[u]);
  k.qm_v = f(qm[v]);
  k.qm_t = f(qm[t]);
  k.bm = f(b.dot(motion));
  k.tt = f(q(t, t));
  k.ts = f(-qm[t]);
  k.ss = f(motion.dot(qm));
  k.planes = planes;
  for (int j = 0; j < planes; j++) {
    const auto i = static_cast<size_t>(j);
    k.nu[j] = f(normal[i][u]);
    k.nv[j] = f(normal[i][v]);
    k.nt[j] = f(normal[i][t]);
    k.offset[j] = f(offset[i]);
    k.slope[j] = f(-normal[i].dot(motion));
  }
}

SweptConvex::View::Tangent tangent_seen(Axis axis, const Vec3& normal) {
  const double nu = normal[u_index(axis)], nv = normal[v_index(axis)],
               nt = normal[depth_index(axis)];
  if (std::abs(nt) < 1e-12) return {};  // parallel to the rays: no ray ends on it
  const auto f = [](double x) { return static_cast<float>(x); };
  return {f(nu), f(nv), f(nt), f(-nu / nt), f(-nv / nt)};
}

}  // namespace

SweptConvex::SweptConvex(const ConvexBody& body, const LatticePoint& tip, const Mat3& frame,
                         const LatticeVector& motion, bool start_is_clear)
    : motion_(motion.units), tip_(tip.units), c_(body.c) {
  q_ = frame * body.q * frame.transpose();
  b_ = frame * body.b;
  for (int j = 0; j < body.planes; j++) {
    plane_normal_[static_cast<size_t>(j)] = frame * body.plane_normal[static_cast<size_t>(j)];
    plane_offset_[static_cast<size_t>(j)] = body.plane_offset[static_cast<size_t>(j)];
  }
  const double length = std::sqrt(motion_.squaredNorm());
  std::array<Vec3, 2> tangents{Vec3::Zero(), Vec3::Zero()};
  if (body.cone && motion_.dot(q_ * motion_) < 0)
    tangents = cone_tangents(q_, plane_normal_[0], motion_);
  recentre_ = length > kRecentreLength;
  if (body.rod_thickness > 0) {
    rod_near_ = std::sqrt(kSlender * body.rod_thickness) - length;
    rod_top_ = body.rod_top;
    axis_ = frame.col(2);
    is_rod_ = rod_top_ > rod_near_;
  }
  for (Axis axis : kAxes) {
    View& k = views_[static_cast<size_t>(axis)];
    set_view(k, axis, q_, b_, c_, motion_, body.planes, plane_normal_, plane_offset_);
    k.tip_u = tip[u_index(axis)];
    k.tip_v = tip[v_index(axis)];
    k.tip_d = tip[depth_index(axis)];
    k.s_min = 0;
    k.s_max = 1;
    k.moving = length > kNoSweep;
    k.quadric = !(body.q.isZero(0) && body.b.isZero(0));
    k.cone = body.cone;
    k.first_face = body.cone && body.plane_offset[0] == 0 ? 1 : 0;
    for (size_t i = 0; i < 2; i++) k.tangents[i] = tangent_seen(axis, tangents[i]);
  }
  // A point can enter the sweep only if one of q, l_j is negative at s = 0 and grows with s. q is
  // concave in s, so it must grow from the start: dq/ds = -2 (Q x + b)'motion > 0 at s = 0.
  if (start_is_clear && !body.cone && length > 0) {
    only_ahead_ = true;
    for (int j = 0; j < body.planes; j++)
      only_ahead_ &= plane_normal_[static_cast<size_t>(j)].dot(motion_) >= 0;
    ahead_ = -(q_ * motion_);
    ahead_offset_ = -b_.dot(motion_);
  }
  const Vec3 size = body.local_bounds.size();
  for (int corner = 0; corner < 8; corner++) {
    Vec3 p = body.local_bounds.min;
    for (int i = 0; i < 3; i++)
      if ((corner >> i) & 1) p[i] += size[i];
    Vec3 at = tip_;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        if (frame(i, j) != 0) at[i] += frame(i, j) * p[j];  // 0 x infinity would be NaN
    bounds_.include(at);
    bounds_.include(Vec3(at + motion_));
  }
  if (!body.local_bounds.min.allFinite() || !body.local_bounds.max.allFinite()) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    bounds_ = {Vec3::Constant(-inf), Vec3::Constant(inf)};
  }
}

// The view of a tile. Its origin is the tip at the pose that is nearest to the tile, seen along the
// rays. For a rod, it is the nearest point of the axis at that pose.
SweptConvex::View SweptConvex::view_at(const RayTile& rays) const {
  View k = views_[static_cast<size_t>(rays.axis)];
  if (!recentre_ && !is_rod_) return k;
  const int u = u_index(rays.axis), v = v_index(rays.axis), t = depth_index(rays.axis);
  const double half = 0.5 * kTileSide;
  const auto nearest = [&](const Vec3& edge, const Vec3& from, double max_share) {
    const double flat2 = edge[u] * edge[u] + edge[v] * edge[v];
    const double du = rays.u0 + half - k.tip_u - from[u], dv = rays.v0 + half - k.tip_v - from[v];
    return flat2 > 0 ? std::clamp((du * edge[u] + dv * edge[v]) / flat2, 0.0, max_share) : 0;
  };
  double s = 0, height = is_rod_ ? nearest(axis_, Vec3::Zero(), rod_top_) : 0;
  if (!recentre_ && height <= rod_near_) return k;
  s = nearest(motion_, height * axis_, 1);
  // Alternate between the two minimisations. Three rounds are accurate enough for an origin.
  for (int turn = 0; is_rod_ && turn < 3; turn++) {
    height = nearest(axis_, s * motion_, rod_top_);
    s = nearest(motion_, height * axis_, 1);
  }
  const Vec3 up = height * axis_, from = s * motion_ + up;
  if (height > 0) {
    const Vec3 grown = q_ * up;
    std::array<double, ConvexBody::kMaxPlanes> offset = plane_offset_;
    for (size_t j = 0; j < static_cast<size_t>(k.planes); j++)
      offset[j] += plane_normal_[j].dot(up);
    set_view(k, rays.axis, q_, b_ + grown, c_ + up.dot(grown + 2 * b_), motion_, k.planes,
             plane_normal_, offset);
  }
  k.tip_u += from[u];
  k.tip_v += from[v];
  k.tip_d += from[t];
  k.s_min = static_cast<float>(-s);
  k.s_max = static_cast<float>(1 - s);
  return k;
}

// True if everything on these rays within the bounds is behind the start pose's silhouette.
bool SweptConvex::only_behind(const RayTile& rays) const {
  return !(max_over_rays(rays, bounds_, ahead_, tip_) + ahead_offset_ > 0);
}

bool SweptConvex::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  if (layer != 0 || (only_ahead_ && only_behind(rays))) return false;
  out.last = true;
  const View k = view_at(rays);
  const int v = v_index(rays.axis);
  // One spare row on each side, for rounding.
  const auto row_of = [&](double at) {
    return static_cast<int>(std::clamp(at - rays.v0, 0.0, static_cast<double>(kTileSide)));
  };
  HWY_DYNAMIC_DISPATCH(ConvexSpans)
  (k, static_cast<float>(rays.u0 + 0.5 - k.tip_u), static_cast<float>(rays.v0 + 0.5 - k.tip_v),
   row_of(bounds_.min[v] - 1.5), row_of(bounds_.max[v] + 1.5), out);
  return out.rows != 0;
}

void SweptConvex::normals(const RayTile& rays, int, const EndMasks& ends, SpanLayer& of) const {
  const View k = view_at(rays);
  HWY_DYNAMIC_DISPATCH(ConvexNormals)
  (k, static_cast<float>(rays.u0 + 0.5 - k.tip_u), static_cast<float>(rays.v0 + 0.5 - k.tip_v),
   ends, of);
}

}  // namespace kibori
#endif
