// SPDX-License-Identifier: MIT
//
// A cut meets a ray's span [in, out) with the tool's [a, b) in one of these ways:
//
//   a══in══b── out        front     masked store: in = b
//   in ──a══out══b        back      masked store: out = a
//   in ──a══════b── out   split     masked stores, here and in the next plane with room, or scalar
//   a══in══out══b         vanish    masked store; later planes then move up
//
// so vectors do nearly all of it. What was removed is summed by the vectors row by row, before the
// row is written, in an order that does not depend on the vector's width. For tools of one interval
// a ray, cut and contact give the same answer to the bit; where a solid has several layers, the
// second finds what the first has left, and the order of additions differs.
#include <kibori/edit/tile_kernel.h>

#include <cmath>

#include <kibori/base/vector_unit.h>
#include <kibori/edit/ray_edit.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kibori/edit/tile_kernel.cpp"
#include <hwy/foreach_target.h>
#include <kibori/base/lanes-inl.h>

#ifndef KIBORI_TILE_KERNEL_SHARED
#define KIBORI_TILE_KERNEL_SHARED
namespace kibori {

// The sums of all lanes; `by_lane`: each lane weighted by its number.
struct LaneTotals {
  double of[LaneSums::kCount], by_lane[LaneSums::kCount];
};

// Whether sums need the scalar path: per element while turning, per span where materials mix.
inline bool scalar_sums(const TileJob& job) {
  return job.request.motion->turning || job.sums_material == kMixedMaterial ||
         (job.request.deep && job.rays.axis == Axis::z);
}
inline bool grain_felt(const TileJob& job, uint8_t material) {
  const Grain* const grain = job.request.motion->grain;
  return grain && grain->felt(material);
}
// Whether what resists is summed as what the tool's surface passed.
inline bool sums_passed(const TileJob& job) {
  const Operation operation = job.request.operation;
  return job.request.motion->passing && !job.request.motion->turning &&
         (operation == Operation::cut || operation == Operation::contact);
}
// From now on the tile is the model's own: a copy of what snapshots share.
inline void make_writable(TileJob& job) {
  job.tile = job.writable = &job.request.field->writable(job.tu, job.tv);
}
// A row's number as a float, so that vectors can load it.
inline constexpr float kRowNumber[kTileSide] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                8, 9, 10, 11, 12, 13, 14, 15};

// Scalar sums for tiles of mixed material and for turning tools: one overlap [lo, hi) of one ray;
// `late` of it is late wood.
void add_overlap(TileJob& job, int row, int lane, float lo, float hi, uint8_t material, double sign,
                 double late);
// Of such an overlap: what the tool's surface passed, and that by twice the depth from t_ref.
void add_passed(TileJob& job, int row, int lane, uint8_t material, double passed, double passed_t2,
                double late);

// Ends beyond this [cells] are no surface.
inline constexpr float kBeyond = 1e6f;
// Where the surface goes less than this share of the tool's way along a ray it all but slides along
// itself; float32 would make something of nothing there.
inline constexpr float kSlides = 0.1f;

}  // namespace kibori
#endif

HWY_BEFORE_NAMESPACE();
namespace kibori {
namespace HWY_NAMESPACE {

// to[i] += factor x[i] in double.
HWY_INLINE void AddDoubles(double* to, VF x, double factor) {
#if HWY_TARGET == HWY_SCALAR
  to[0] += factor * static_cast<double>(hn::GetLane(x));
#else
  const hn::Half<DF> half;
  const hn::Rebind<double, decltype(half)> d64;
  const auto f = hn::Set(d64, factor);
  const size_t n = kLanes / 2;
  hn::StoreU(hn::Add(hn::LoadU(d64, to), hn::Mul(f, hn::PromoteTo(d64, hn::LowerHalf(half, x)))),
             d64, to);
  hn::StoreU(
      hn::Add(hn::LoadU(d64, to + n), hn::Mul(f, hn::PromoteTo(d64, hn::UpperHalf(half, x)))), d64,
      to + n);
#endif
}

// What is summed of each overlap [lo, hi).
enum Summed : unsigned { kNothing = 0, kLengths = 1, kNodes = 2, kFelt = 4, kPassed = 8 };

// The mean of late_wood over overlaps of the rays of a row, from the lane `at` on.
HWY_INLINE void LateWood(const TileJob& job, size_t row, size_t at, const float* lo,
                         const float* hi, size_t count, float* late) {
  const float u = static_cast<float>(job.rays.u0) + static_cast<float>(at) + 0.5f,
              v = static_cast<float>(job.rays.v0) + static_cast<float>(row) + 0.5f;
  job.request.motion->grain->late_wood_of(job.rays.axis, u, v, lo, hi, count, late);
}

// How far the tool's surface goes along the rays of a row [cells], out of the tool, at that end of
// its intervals: by how these ends go on from ray to ray.
HWY_INLINE VF Advance(const TileJob& job, size_t row, size_t g, bool at_hi) {
  const DF d;
  const SpanLayer& spans = job.spans;
  const float* const ends = at_hi ? spans.hi : spans.lo;
  const auto end_at = [&](size_t of_row, size_t group) HWY_ATTR {
    const size_t slot = of_row * kTileSide + group * kLanes;
    const MF there = hn::Lt(hn::Load(d, spans.lo + slot), hn::Load(d, spans.hi + slot));
    return hn::IfThenElse(there, hn::Load(d, ends + slot), F(kFar));
  };
  const auto beside = [&](size_t of_row) HWY_ATTR {
    return of_row < kTileSide && ((spans.rows >> of_row) & 1) ? end_at(of_row, g) : F(kFar);
  };
  const VF end = end_at(row, g);
  const auto slope = [&](VF before, VF after) HWY_ATTR {
    const MF down = hn::Lt(hn::Abs(before), F(kBeyond)), up = hn::Lt(hn::Abs(after), F(kBeyond));
    const VF rise = hn::Add(hn::IfThenElseZero(down, hn::Sub(end, before)),
                            hn::IfThenElseZero(up, hn::Sub(after, end)));
    return hn::IfThenElse(hn::And(down, up), hn::Mul(rise, F(0.5f)), rise);
  };
  alignas(64) float line[3 * kRow];
  line[kRow - 1] = line[2 * kRow] = kFar;
  for (size_t group = 0; group < kGroups; group++)
    hn::Store(end_at(row, group), d, line + kRow + group * kLanes);
  const float* const here = line + kRow + g * kLanes;
  const LatticeVector& shift = job.request.motion->shift;
  const Axis axis = job.rays.axis;
  const auto along = [&](int world) { return F(static_cast<float>(shift.units[world])); };
  const VF way = hn::Sub(
      hn::Sub(along(depth_index(axis)),
              hn::Mul(along(u_index(axis)), slope(hn::LoadU(d, here - 1), hn::LoadU(d, here + 1)))),
      hn::Mul(along(v_index(axis)), slope(beside(row - 1), beside(row + 1))));
  return hn::IfThenElseZero(hn::Lt(hn::Abs(end), F(kBeyond)), at_hi ? way : hn::Neg(way));
}

// Overlaps [lo, hi) of rays of a row: what the tool's surface passed of them, and that by twice the
// depth from t_ref. Material goes on at the ends that are `made`, so the tool's surface is there.
struct Passed {
  VF way, way_t2;

  HWY_INLINE Passed(const TileJob& job, size_t row, size_t g, MF hit, MF made_lo, MF made_hi, VF lo,
                    VF hi, VF twice_ref) {
    const DF d;
    const Vec3& shift = job.request.motion->shift.units;
    const double size = shift.norm(), along = shift[depth_index(job.rays.axis)];
    const VF len = hn::Sub(hi, lo), zero = hn::Zero(d);
    way = way_t2 = zero;
    const auto add = [&](MF where, VF by, VF twice_depth) HWY_ATTR {
      by = hn::IfThenElseZero(where, by);
      way = hn::Add(way, by);
      way_t2 =
          hn::Add(way_t2, hn::IfThenElseZero(where, hn::Mul(by, hn::Sub(twice_depth, twice_ref))));
    };
    // The surface was there last; it passed the piece's other end as much earlier as it goes on.
    const auto add_end = [&](MF made, bool at_hi, float sign) HWY_ATTR {
      made = hn::And(hit, made);
      if (hn::AllFalse(d, made)) return;
      const VF goes = Advance(job, row, g, at_hi),
               all = hn::Max(goes, F(kSlides * static_cast<float>(size))), part = hn::Min(len, all);
      const VF by = hn::Mul(F(sign * static_cast<float>(along)), hn::Div(part, all));
      const VF end = at_hi ? hi : lo;
      const VF twice = hn::Add(end, end);
      add(hn::And(made, hn::Gt(goes, zero)), by,
          at_hi ? hn::Sub(twice, part) : hn::Add(twice, part));
    };
    add_end(made_hi, true, 1);
    add_end(made_lo, false, -1);
    // What was swallowed whole counts by the motion's direction.
    const MF whole = hn::AndNot(hn::Or(made_lo, made_hi), hit);
    if (hn::AllFalse(d, whole)) return;
    const double share = along / size;
    add(whole,
        hn::Mul(F(static_cast<float>(share * share)), hn::Min(len, F(static_cast<float>(size)))),
        hn::Add(lo, hi));
  }
};

// Sums over one tile's rows, in registers.
template <unsigned kSummed>
struct Sums {
  VF length, length_v, length_t2, nodes, nodes_v, nodes_t2, felt, felt_v, felt_t2;

  HWY_INLINE Sums() {
    length = length_v = length_t2 = nodes = nodes_v = nodes_t2 = hn::Zero(DF());
    felt = felt_v = felt_t2 = hn::Zero(DF());
  }
  // Adds where `hit`; `twice_ref` is 2 t_ref; `made`: as of Passed.
  HWY_INLINE void Add(const TileJob& job, size_t at_row, size_t g, MF hit, VF lo, VF hi,
                      VF twice_ref, MF made_lo, MF made_hi) {
    if constexpr (kSummed == kNothing) return;
    const VF len = hn::IfThenElseZero(hit, hn::Sub(hi, lo)), row = F(kRowNumber[at_row]);
    const VF twice_depth = hn::Sub(hn::Add(lo, hi), twice_ref);
    length = hn::Add(length, len);
    length_v = hn::Add(length_v, hn::Mul(len, row));
    length_t2 = hn::Add(length_t2, hn::Mul(len, twice_depth));
    if constexpr ((kSummed & kPassed) != 0) {
      const Passed passed(job, at_row, g, hit, made_lo, made_hi, lo, hi, twice_ref);
      const VF resists = Resists(job, at_row, g, hit, lo, hi), more = hn::Mul(passed.way, resists);
      felt = hn::Add(felt, more);
      felt_v = hn::Add(felt_v, hn::Mul(more, row));
      felt_t2 = hn::Add(felt_t2, hn::Mul(passed.way_t2, resists));
    } else if constexpr ((kSummed & kFelt) != 0) {
      const VF more = hn::Mul(len, Resists(job, at_row, g, hit, lo, hi));
      felt = hn::Add(felt, more);
      felt_v = hn::Add(felt_v, hn::Mul(more, row));
      felt_t2 = hn::Add(felt_t2, hn::Mul(more, twice_depth));
    }
    if constexpr ((kSummed & kNodes) != 0) {
      // Nodes k with lo <= k + 1/2 < hi. Whole numbers below 2^24 all along, as `deep` tools take
      // the scalar path.
      const VF k0 = hn::Ceil(hn::Sub(lo, F(0.5f))), k1 = hn::Ceil(hn::Sub(hi, F(0.5f)));
      const VF n = hn::IfThenElseZero(hit, hn::Sub(k1, k0));
      nodes = hn::Add(nodes, n);
      nodes_v = hn::Add(nodes_v, hn::Mul(n, row));
      const VF twice_mean = hn::Sub(hn::Sub(hn::Add(k0, k1), F(1.0f)), twice_ref);
      nodes_t2 = hn::Add(nodes_t2, hn::Mul(n, twice_mean));
    }
  }
  // Of u, by the rings in each overlap.
  static HWY_INLINE VF Resists(const TileJob& job, size_t row, size_t g, MF hit, VF lo, VF hi) {
    const DF d;
    if (!grain_felt(job, job.sums_material)) return F(1.0f);
    const auto ring = static_cast<float>(job.request.motion->grain->ring(job.sums_material));
    if (ring == 0 || hn::AllFalse(d, hit)) return F(1.0f);
    alignas(64) float los[kLanes], his[kLanes], late[kLanes];
    hn::Store(lo, d, los);
    hn::Store(hi, d, his);
    LateWood(job, row, g * kLanes, los, his, kLanes, late);
    return hn::Add(F(1.0f),
                   hn::Mul(F(ring), hn::Sub(hn::Load(d, late), F(static_cast<float>(kMeanLate)))));
  }
  HWY_INLINE void AddTo(TileJob& job, size_t g, bool negative) const {
    if constexpr (kSummed == kNothing) return;
    if (job.sums.material != job.sums_material) take_sums(job);
    LaneSums& to = job.sums;
    const RayTile& rays = job.rays;
    const double sign = negative ? -1 : 1, u0 = sign * rays.u0, v0 = sign * rays.v0;
    const size_t at = g * kLanes;
    // A sum, the same by rows, and by twice the depth; `of` is the first of its four.
    const auto add = [&](size_t of, VF sum, VF by_v, VF by_t2) HWY_ATTR {
      AddDoubles(to.of[of] + at, sum, sign);
      AddDoubles(to.of[of + 1] + at, sum, u0);
      AddDoubles(to.of[of + 2] + at, sum, v0);
      AddDoubles(to.of[of + 2] + at, by_v, sign);
      AddDoubles(to.of[of + 3] + at, by_t2, sign);
    };
    add(LaneSums::length, length, length_v, length_t2);
    if constexpr ((kSummed & (kFelt | kPassed)) != 0) add(LaneSums::felt, felt, felt_v, felt_t2);
    if constexpr ((kSummed & kNodes) != 0) add(LaneSums::nodes, nodes, nodes_v, nodes_t2);
  }
};

// The sums of tiles that scalar_sums() names: overlaps of cuts, or what a deposit adds. Row by row,
// plane by plane and lane by lane, so that the order of additions does not depend on the vector's
// width.
void AddScalarSums(TileJob& job, bool growing) {
  const DF d;
  alignas(64) float los[kRow], his[kRow], late[kRow], way[kRow], way_t2[kRow];
  const bool grained = job.request.motion->grain != nullptr, passed = sums_passed(job);
  for (unsigned left = job.spans.rows; left; left &= left - 1) {
    const int row = __builtin_ctz(left);
    const float *a = job.spans.lo + row * kTileSide, *b = job.spans.hi + row * kTileSide;
    if (growing) {
      if (grained) LateWood(job, static_cast<size_t>(row), 0, a, b, kRow, late);
      for (int lane = 0; lane < kTileSide; lane++)
        if (a[lane] < b[lane])
          add_overlap(job, row, lane, a[lane], b[lane], job.request.material, 1,
                      grained ? late[lane] : 0);
    }
    for (const Plane* p = &job.tile->first; p; p = p->next) {
      unsigned hits = 0;
      for (size_t g = 0; g < kGroups; g++) {
        const size_t at = g * kLanes, slot = static_cast<size_t>(row) * kTileSide + at;
        const VF lo = hn::Max(hn::Load(d, p->in + slot), hn::Load(d, a + at));
        const VF hi = hn::Min(hn::Load(d, p->out + slot), hn::Load(d, b + at));
        hn::Store(lo, d, los + at);
        hn::Store(hi, d, his + at);
        const MF hit = hn::Lt(lo, hi);
        hits |= Bits(hit) << at;
        if (!passed || hn::AllFalse(d, hit)) continue;
        const Passed by(job, static_cast<size_t>(row), g, hit,
                        hn::Gt(hn::Load(d, a + at), hn::Load(d, p->in + slot)),
                        hn::Lt(hn::Load(d, b + at), hn::Load(d, p->out + slot)), lo, hi,
                        F(2 * job.request.t_ref));
        hn::Store(by.way, d, way + at);
        hn::Store(by.way_t2, d, way_t2 + at);
      }
      if (hits && grained) LateWood(job, static_cast<size_t>(row), 0, los, his, kRow, late);
      for (; hits; hits &= hits - 1) {
        const int lane = __builtin_ctz(hits);
        add_overlap(job, row, lane, los[lane], his[lane], p->material[row * kTileSide + lane],
                    growing ? -1 : 1, grained ? late[lane] : 0);
        if (passed)
          add_passed(job, row, lane, p->material[row * kTileSide + lane], way[lane], way_t2[lane],
                     grained ? late[lane] : 0);
      }
    }
  }
}

// What a cut would remove: the same sums in the same order, and no writes.
template <unsigned kSummed>
void ContactCut(TileJob& job) {
  const DF d;
  for (size_t g = 0; g < kGroups; g++) {
    Sums<kSummed> sum;
    MF met = hn::FirstN(d, 0);
    for (const Plane* p = &job.tile->first; p; p = p->next) {
      if (!p->reaches(job.request.depth_min, job.request.depth_max)) continue;
      for (unsigned left = job.spans.rows; left; left &= left - 1) {
        const auto row = static_cast<size_t>(__builtin_ctz(left));
        const size_t slot = row * kTileSide + g * kLanes;
        const VF a = hn::Load(d, job.spans.lo + slot), b = hn::Load(d, job.spans.hi + slot);
        const VF in = hn::Load(d, p->in + slot), out = hn::Load(d, p->out + slot);
        const VF lo = hn::Max(in, a), hi = hn::Min(out, b);
        const MF hit = hn::Lt(lo, hi);
        if ((kSummed & kPassed) != 0 && hn::AllFalse(d, hit)) continue;
        met = hn::Or(met, hit);
        sum.Add(job, row, g, hit, lo, hi, F(2 * job.request.t_ref), hn::Gt(a, in), hn::Lt(b, out));
      }
    }
    if (hn::AllFalse(d, met)) continue;
    job.met = true;
    sum.AddTo(job, g, false);
  }
}

// Whether any interval meets any span.
bool Meets(const TileJob& job) {
  const DF d;
  for (unsigned left = job.spans.rows; left; left &= left - 1) {
    for (size_t g = 0; g < kGroups; g++) {
      const size_t slot = static_cast<size_t>(__builtin_ctz(left)) * kTileSide + g * kLanes;
      const VF a = hn::Load(d, job.spans.lo + slot), b = hn::Load(d, job.spans.hi + slot);
      for (const Plane* p = &job.tile->first; p; p = p->next) {
        const VF lo = hn::Max(hn::Load(d, p->in + slot), a),
                 hi = hn::Min(hn::Load(d, p->out + slot), b);
        if (!hn::AllFalse(d, hn::Lt(lo, hi))) return true;
      }
    }
  }
  return false;
}

// The ends that `lanes` of a row got from the tool: their normals now where the row is in
// `normals_ready`, else by name for later.
HWY_INLINE void GiveNormals(TileJob& job, Plane& plane, unsigned normals_ready, size_t row,
                            size_t g, MF lanes, bool at_in) {
  const DU du;
  const size_t slot = row * kTileSide + g * kLanes;
  if ((normals_ready >> row) & 1) {
    // What is left begins where the tool ends, and ends where the tool begins.
    const VU code = hn::Load(du, (at_in ? job.spans.codes.hi : job.spans.codes.lo) + slot);
    hn::BlendedStore(code, hn::RebindMask(du, lanes), du,
                     (at_in ? plane.normal_in : plane.normal_out) + slot);
  } else {
    const unsigned bits = Bits(lanes) << (g * kLanes);
    job.ends.mark(row, at_in ? 0 : bits, at_in ? bits : 0);
  }
}

// A row of a cut in which spans vanish or split.
HWY_NOINLINE void CutHardRow(TileJob& job, Plane& plane, size_t row, size_t g) {
  const DF d;
  const DU du;
  const size_t slot = row * kTileSide + g * kLanes;
  const VF a = hn::Load(d, job.spans.lo + slot), b = hn::Load(d, job.spans.hi + slot);
  const VF in = hn::Load(d, plane.in + slot), out = hn::Load(d, plane.out + slot);
  const MF hit = hn::Lt(hn::Max(in, a), hn::Min(out, b));
  const MF front = hn::And(hit, hn::Le(a, in)), back = hn::And(hit, hn::Ge(b, out));
  const unsigned normals_ready = plane.paint ? 0 : job.spans.normals_ready;
  const MF trim_in = hn::AndNot(back, front), trim_out = hn::AndNot(front, back);
  hn::BlendedStore(b, trim_in, d, plane.in + slot);
  hn::BlendedStore(a, trim_out, d, plane.out + slot);
  GiveNormals(job, plane, normals_ready, row, g, trim_in, true);
  GiveNormals(job, plane, normals_ready, row, g, trim_out, false);
  unsigned hard = 0;
  const MF split = hn::AndNot(hn::Or(front, back), hit);
  if (!hn::AllFalse(d, split)) {
    // What lies behind the tool moves to the next plane, if there is room in it.
    Plane& next = job.request.field->next_plane(plane);
    MF room = hn::And(split, hn::Ge(hn::Load(d, next.in + slot), hn::Load(d, next.out + slot)));
    if (plane.paint || next.paint) room = hn::FirstN(d, 0);
    hard |= Bits(hn::AndNot(room, split));
    hn::BlendedStore(a, room, d, plane.out + slot);
    hn::BlendedStore(b, room, d, next.in + slot);
    hn::BlendedStore(out, room, d, next.out + slot);
    next.include(plane.near, plane.far);
    next.tight = false;
    hn::BlendedStore(hn::Load(du, plane.normal_out + slot), hn::RebindMask(du, room), du,
                     next.normal_out + slot);
    GiveNormals(job, plane, normals_ready, row, g, room, false);
    GiveNormals(job, next, normals_ready, row, g, room, true);
    for (unsigned bits = Bits(room); bits; bits &= bits - 1) {
      const size_t lane = slot + static_cast<size_t>(__builtin_ctz(bits));
      next.material[lane] = plane.material[lane];
    }
  }
  const MF vanish = hn::And(front, back);
  if (!hn::AllFalse(d, vanish)) {
    hn::BlendedStore(F(kFar), vanish, d, plane.in + slot);
    hn::BlendedStore(F(-kFar), vanish, d, plane.out + slot);
    job.gaps |= static_cast<uint16_t>(1u << row);
  }
  if (hard) {
    job.scalar.rows[row] |= static_cast<uint16_t>(hard << (g * kLanes));
    job.scalar.any = true;
  }
}

// Moves the spans of `lanes` from one plane to an earlier one, where those lanes are empty.
HWY_INLINE void MoveSpans(Field& field, Plane& from, Plane& to, MF lanes, size_t slot) {
  const DF d;
  const DU du;
  const auto move = [&](const uint32_t* source, uint32_t* target) HWY_ATTR {
    hn::BlendedStore(hn::Load(du, source + slot), hn::RebindMask(du, lanes), du, target + slot);
  };
  hn::BlendedStore(hn::Load(d, from.in + slot), lanes, d, to.in + slot);
  hn::BlendedStore(hn::Load(d, from.out + slot), lanes, d, to.out + slot);
  hn::BlendedStore(F(kFar), lanes, d, from.in + slot);
  hn::BlendedStore(F(-kFar), lanes, d, from.out + slot);
  move(from.normal_in, to.normal_in);
  move(from.normal_out, to.normal_out);
  for (unsigned bits = Bits(lanes); bits; bits &= bits - 1) {
    const size_t lane = slot + static_cast<size_t>(__builtin_ctz(bits));
    to.material[lane] = from.material[lane];
    if (!from.paint && !to.paint) continue;
    PaintPlane& paint = field.paint_of(to);
    paint.in[lane] = from.paint ? from.paint->in[lane] : 0;
    paint.out[lane] = from.paint ? from.paint->out[lane] : 0;
  }
  to.include(from.near, from.far);
  to.tight = from.tight = false;
}

// Closes the gaps that vanished spans left in a row: later planes move up.
HWY_NOINLINE void CloseGaps(TileJob& job, Plane& first, size_t row) {
  const DF d;
  for (size_t g = 0; g < kGroups; g++) {
    const size_t slot = row * kTileSide + g * kLanes;
    const auto filled = [&](const Plane& p) HWY_ATTR {
      return hn::Lt(hn::Load(d, p.in + slot), hn::Load(d, p.out + slot));
    };
    for (Plane* to = &first; to->next; to = to->next)
      for (Plane* from = to->next; from; from = from->next) {
        const MF lanes = hn::AndNot(filled(*to), filled(*from));
        if (!hn::AllFalse(d, lanes)) MoveSpans(*job.request.field, *from, *to, lanes, slot);
      }
  }
}

bool HasSpans(const Plane& plane) {
  const DF d;
  for (size_t slot = 0; slot < kTileRays; slot += kLanes)
    if (!hn::AllFalse(d, hn::Lt(hn::Load(d, plane.in + slot), hn::Load(d, plane.out + slot))))
      return true;
  return false;
}

// Makes a plane's bounds tight.
HWY_NOINLINE void Tighten(Plane& plane) {
  const DF d;
  VF near = F(kFar), far = F(-kFar);
  for (size_t slot = 0; slot < kTileRays; slot += kLanes) {
    near = hn::Min(near, hn::Load(d, plane.in + slot));
    far = hn::Max(far, hn::Load(d, plane.out + slot));
  }
  plane.near = hn::GetLane(hn::MinOfLanes(d, near));
  plane.far = hn::GetLane(hn::MaxOfLanes(d, far));
  plane.tight = true;
}

// A cut of a tile that may be written, plane by plane.
template <unsigned kSummed>
void CutTile(TileJob& job) {
  const DF d;
  const SpanLayer& spans = job.spans;
  const VF twice_ref = F(2 * job.request.t_ref);
  Plane* const first = &job.writable->first;
  uint64_t met_planes = 0;  // by number; those beyond the 63rd count as one
  for (size_t g = 0; g < kGroups; g++) {
    Sums<kSummed> sum;
    bool met_here = false;
    uint64_t number = 1;
    for (Plane* p = first; p; p = p->next, number = number << 1 | number >> 63 << 63) {
      if (!p->reaches(job.request.depth_min, job.request.depth_max)) continue;
      bool met = false;
      const unsigned normals_ready = p->paint ? 0 : spans.normals_ready;
      for (unsigned left = spans.rows; left; left &= left - 1) {
        const auto row = static_cast<size_t>(__builtin_ctz(left));
        const size_t slot = row * kTileSide + g * kLanes;
        const VF a = hn::Load(d, spans.lo + slot), b = hn::Load(d, spans.hi + slot);
        const VF in = hn::Load(d, p->in + slot), out = hn::Load(d, p->out + slot);
        const VF lo = hn::Max(in, a), hi = hn::Min(out, b);
        const MF hit = hn::Lt(lo, hi);
        if (hn::AllFalse(d, hit)) continue;
        met = true;
        sum.Add(job, row, g, hit, lo, hi, twice_ref, hn::Gt(a, in), hn::Lt(b, out));
        // The tool covers the span's beginning, its end, both, or neither.
        const MF front = hn::And(hit, hn::Le(a, in)), back = hn::And(hit, hn::Ge(b, out));
        if (!hn::AllFalse(d, hn::AndNot(hn::Xor(front, back), hit))) {
          CutHardRow(job, *p, row, g);
          continue;
        }
        if (!hn::AllFalse(d, front)) {
          hn::BlendedStore(b, front, d, p->in + slot);
          GiveNormals(job, *p, normals_ready, row, g, front, true);
        }
        if (!hn::AllFalse(d, back)) {
          hn::BlendedStore(a, back, d, p->out + slot);
          GiveNormals(job, *p, normals_ready, row, g, back, false);
        }
      }
      if (met) {
        met_here = job.met = true;
        met_planes |= number;
        p->tight = false;
      }
    }
    if (met_here) sum.AddTo(job, g, false);
  }
  for (unsigned left = job.gaps; left; left &= left - 1)
    CloseGaps(job, *first, static_cast<size_t>(__builtin_ctz(left)));
  if (job.gaps) {
    const Plane* last = first;
    while (last->next) last = last->next;
    job.shrank = !HasSpans(*last);
  }
  // Planes that were visited in vain: the next edit may be spared.
  uint64_t number = 1;
  for (Plane* p = first; p; p = p->next, number = number << 1 | number >> 63 << 63)
    if (!p->tight && !(met_planes & number) &&
        p->reaches(job.request.depth_min, job.request.depth_max))
      Tighten(*p);
}

// Deposit (or its contact test): what is added is the interval less its overlaps.
template <bool kWrite, unsigned kSummed>
void DepositTile(TileJob& job) {
  const DF d;
  const Plane* first = &job.tile->first;
  // What is added lies within the solid's bounds and the lattice.
  const float min = std::max(0.0f, static_cast<float>(job.request.depth_min) - 1);
  const float max = std::max(0.0f, static_cast<float>(job.request.depth_max) + 1);
  const auto grown = [&](Plane& plane) {
    plane.include(min, max);
    plane.tight = false;
  };
  for (size_t g = 0; g < kGroups; g++) {
    Sums<kSummed> sum, less;
    bool met = false;
    for (unsigned left = job.spans.rows; left; left &= left - 1) {
      const int row = __builtin_ctz(left);
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      const VF a = hn::Load(d, job.spans.lo + slot), b = hn::Load(d, job.spans.hi + slot);
      const MF live = hn::Lt(a, b);
      if (hn::AllFalse(d, live)) continue;
      MF covered = hn::FirstN(d, 0), touched = covered, twice = covered;
      for (const Plane* p = first; p; p = p->next) {
        const VF in = hn::Load(d, p->in + slot), out = hn::Load(d, p->out + slot);
        covered = hn::Or(covered, hn::And(hn::Le(in, a), hn::Ge(out, b)));
        const MF touch = hn::And(live, hn::And(hn::Le(in, b), hn::Le(a, out)));
        twice = hn::Or(twice, hn::And(touched, touch));
        touched = hn::Or(touched, touch);
      }
      const MF adds = hn::AndNot(covered, live);
      if (hn::AllFalse(d, adds)) continue;
      met = true;
      sum.Add(job, static_cast<size_t>(row), g, adds, a, b, F(2 * job.request.t_ref), adds, adds);
      for (const Plane* p = first; p; p = p->next) {
        const VF lo = hn::Max(hn::Load(d, p->in + slot), a),
                 hi = hn::Min(hn::Load(d, p->out + slot), b);
        const MF hit = hn::And(adds, hn::Lt(lo, hi));
        if (hn::AllFalse(d, hit)) continue;
        less.Add(job, static_cast<size_t>(row), g, hit, lo, hi, F(2 * job.request.t_ref), hit, hit);
      }
      if constexpr (kWrite) {
        if (!job.writable) {
          make_writable(job);
          first = &job.tile->first;
        }
        Plane* const own = &job.writable->first;
        // Easy: the ray is empty, or exactly one span of the same, sole material grows.
        const bool sole = job.tile->empty || job.tile->material == job.request.material;
        unsigned hard = Bits(adds);
        if (sole) {
          const VF in0 = hn::Load(d, first->in + slot), out0 = hn::Load(d, first->out + slot);
          const MF empty = hn::Ge(in0, out0);
          const MF easy = hn::AndNot(twice, hn::And(adds, hn::Or(empty, touched)));
          hard &= ~Bits(easy);
          const MF fresh = hn::And(easy, empty);
          if (!hn::AllFalse(d, fresh)) {
            grown(*own);
            hn::Store(hn::IfThenElse(fresh, a, in0), d, own->in + slot);
            hn::Store(hn::IfThenElse(fresh, b, out0), d, own->out + slot);
            for (unsigned bits = Bits(fresh); bits; bits &= bits - 1)
              own->material[slot + static_cast<size_t>(__builtin_ctz(bits))] = job.request.material;
            job.ends.mark(static_cast<size_t>(row), Bits(fresh) << (g * kLanes),
                          Bits(fresh) << (g * kLanes));
          }
          const MF grow = hn::AndNot(empty, easy);
          if (!hn::AllFalse(d, grow)) {
            for (Plane* p = own; p; p = p->next) {
              const VF in = hn::Load(d, p->in + slot), out = hn::Load(d, p->out + slot);
              const MF here = hn::And(grow, hn::And(hn::Le(in, b), hn::Le(a, out)));
              const MF down = hn::And(here, hn::Lt(a, in)), up = hn::And(here, hn::Gt(b, out));
              grown(*p);
              hn::Store(hn::IfThenElse(down, a, in), d, p->in + slot);
              hn::Store(hn::IfThenElse(up, b, out), d, p->out + slot);
              job.ends.mark(static_cast<size_t>(row), Bits(down) << (g * kLanes),
                            Bits(up) << (g * kLanes));
            }
          }
        }
        if (hard) {
          job.scalar.rows[row] |= static_cast<uint16_t>(hard << (g * kLanes));
          job.scalar.any = true;
        }
      }
    }
    if (!met) continue;
    job.met = true;
    sum.AddTo(job, g, false);
    less.AddTo(job, g, true);
  }
}

void PaintTile(TileJob& job) {
  const DF d;
  const DU du;
  const auto plane_at = [](Tile& tile, int index) -> Plane& {
    Plane* plane = &tile.first;
    for (; index > 0; index--) plane = plane->next;
    return *plane;
  };
  for (int row = 0; row < kTileSide; row++) {
    if (!((job.spans.rows >> row) & 1)) continue;
    for (size_t g = 0; g < kGroups; g++) {
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      const VF a = hn::Load(d, job.spans.lo + slot), b = hn::Load(d, job.spans.hi + slot);
      int index = 0;
      for (const Plane* p = &job.tile->first; p; p = p->next, index++) {
        const VF in = hn::Load(d, p->in + slot), out = hn::Load(d, p->out + slot);
        const MF there = hn::Lt(in, out);
        const MF at_in = hn::And(there, hn::And(hn::Ge(in, a), hn::Lt(in, b)));
        const MF at_out = hn::And(there, hn::And(hn::Gt(out, a), hn::Le(out, b)));
        if (hn::AllFalse(d, hn::Or(at_in, at_out))) continue;
        if (!job.writable) make_writable(job);
        Plane& own = plane_at(*job.writable, index);
        p = &own;
        PaintPlane& paint = job.request.field->paint_of(own);
        hn::BlendedStore(hn::Set(du, job.request.color), hn::RebindMask(du, at_in), du,
                         paint.in + slot);
        hn::BlendedStore(hn::Set(du, job.request.color), hn::RebindMask(du, at_out), du,
                         paint.out + slot);
        job.removed->ends_painted +=
            __builtin_popcount(Bits(at_in)) + __builtin_popcount(Bits(at_out));
      }
    }
  }
}

// Gives the ends that `ends` names their normals. cutting: material ends where the tool begins;
// growing: it begins there.
void StoreNormals(TileJob& job, bool cutting) {
  const DF d;
  const DU du;
  Plane* first = &job.writable->first;
  for (int at_lo = 0; at_lo < 2; at_lo++) {
    const uint16_t* masks = at_lo ? job.ends.lo : job.ends.hi;
    const float* made = at_lo ? job.spans.lo : job.spans.hi;
    const uint32_t* codes = at_lo ? job.spans.codes.lo : job.spans.codes.hi;
    const bool is_in = cutting != (at_lo != 0);
    for (unsigned left = job.ends.rows; left; left &= left - 1) {
      const int row = __builtin_ctz(left);
      for (size_t g = 0; g < kGroups; g++) {
        const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
        const MF mask = FromBits((masks[row] >> (g * kLanes)) & kGroupMask);
        const VU code = hn::Load(du, codes + slot);
        // With several planes, the end is in the one that has the very number.
        for (Plane* p = first; p; p = p->next) {
          MF here = mask;
          if (first->next)
            here = hn::And(mask, hn::Eq(hn::Load(d, (is_in ? p->in : p->out) + slot),
                                        hn::Load(d, made + slot)));
          hn::BlendedStore(code, hn::RebindMask(du, here), du,
                           (is_in ? p->normal_in : p->normal_out) + slot);
          if (p->paint)
            hn::BlendedStore(hn::Zero(du), hn::RebindMask(du, here), du,
                             (is_in ? p->paint->in : p->paint->out) + slot);
        }
      }
    }
  }
}

template <unsigned kSummed>
HWY_INLINE void RunSummed(TileJob& job) {
  switch (job.request.operation) {
    case Operation::cut:
      // Take the tile for writing only if there is something to write.
      if (job.request.field->shared(job.tu, job.tv) && !Meets(job)) return;
      job.tile = job.writable = &job.request.field->maybe_writable(job.tu, job.tv);
      return CutTile<kSummed>(job);
    case Operation::contact:
      return ContactCut<kSummed>(job);
    case Operation::deposit:
      return DepositTile<true, kSummed>(job);
    case Operation::deposit_contact:
      return DepositTile<false, kSummed>(job);
    case Operation::paint:
      return;  // sums nothing: RunVectors
  }
}

void ClearSums(LaneSums& sums) {
  const hn::CappedTag<double, 8> d;
  for (auto& lanes : sums.of)
    for (size_t at = 0; at < kTileSide; at += hn::MaxLanes(d))
      hn::StoreU(hn::Zero(d), d, lanes + at);
}

// All lanes together. Fixed pairwise trees, so that the order does not depend on the vector's
// width.
void ReduceSums(const LaneSums& sums, LaneTotals& totals) {
  for (size_t i = 0; i < LaneSums::kCount; i++) {
    double x[kTileSide / 2], by_lane[kTileSide / 2];
    const double* lanes = sums.of[i];
    for (int j = 0; j < 8; j++) x[j] = lanes[j] + lanes[j + 8];
    for (int j = 0; j < 8; j++) by_lane[j] = lanes[j] * j + lanes[j + 8] * (j + 8);
    for (int j = 0; j < 4; j++) x[j] += x[j + 4];
    for (int j = 0; j < 4; j++) by_lane[j] += by_lane[j + 4];
    totals.of[i] = (x[0] + x[2]) + (x[1] + x[3]);
    totals.by_lane[i] = (by_lane[0] + by_lane[2]) + (by_lane[1] + by_lane[3]);
  }
}

void RunVectors(TileJob& job) {
  const Operation operation = job.request.operation;
  const bool growing = operation == Operation::deposit || operation == Operation::deposit_contact;
  if (operation == Operation::paint) {
    PaintTile(job);
  } else if (scalar_sums(job)) {
    AddScalarSums(job, growing);
    RunSummed<kNothing>(job);
  } else if (sums_passed(job)) {
    if (job.rays.axis == Axis::z)
      RunSummed<kLengths | kNodes | kPassed>(job);
    else
      RunSummed<kLengths | kPassed>(job);
  } else if (grain_felt(job, job.sums_material)) {
    if (job.rays.axis == Axis::z)
      RunSummed<kLengths | kNodes | kFelt>(job);
    else
      RunSummed<kLengths | kFelt>(job);
  } else if (job.rays.axis == Axis::z) {
    RunSummed<kLengths | kNodes>(job);
  } else {
    RunSummed<kLengths>(job);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kibori
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kibori {
HWY_EXPORT(RunVectors);
HWY_EXPORT(StoreNormals);
HWY_EXPORT(ClearSums);
HWY_EXPORT(ReduceSums);

// Of u: what a piece resists of which `late` is late wood.
static double grain_resists(const TileJob& job, uint8_t material, double across2, double late) {
  const Grain& grain = *job.request.motion->grain;
  return grain.by_direction(material, across2) * (1 + grain.ring(material) * (late - kMeanLate));
}

void add_overlap(TileJob& job, int row, int lane, float lo, float hi, uint8_t span_material,
                 double sign, double late) {
  const auto axis = static_cast<size_t>(job.rays.axis);
  const int ui = u_index(job.rays.axis), vi = v_index(job.rays.axis),
            ti = depth_index(job.rays.axis);
  // What a deposit meets counts as much as what it puts down, of which it is taken away.
  const uint8_t material =
      job.request.material == kMixedMaterial ? span_material : job.request.material;
  RemovedPart& part = job.removed->part(material);
  const Motion& motion = *job.request.motion;
  const double length = sign * (static_cast<double>(hi) - lo);
  Vec3 r;
  r[ui] = job.rays.u0 + lane + 0.5 - motion.reference[ui];
  r[vi] = job.rays.v0 + row + 0.5 - motion.reference[vi];
  r[ti] = 0.5 * (static_cast<double>(lo) + hi) - motion.reference[ti];
  part.volume[axis] += length;
  part.moment[axis] += length * r;
  if (job.rays.axis == Axis::z) {
    const auto k0 = static_cast<int64_t>(std::ceil(lo - 0.5f)),
               k1 = static_cast<int64_t>(std::ceil(hi - 0.5f));
    const int64_t n = sign < 0 ? k0 - k1 : k1 - k0;
    part.points += n;
    part.node_sum[static_cast<size_t>(ui)] += n * (job.rays.u0 + lane);
    part.node_sum[static_cast<size_t>(vi)] += n * (job.rays.v0 + row);
    part.node_sum[static_cast<size_t>(ti)] += n * (k0 + k1 - 1) / 2;
  }
  const Vec3 s =
      motion.turning ? Vec3(motion.shift.units + motion.turn.cross(r)) : Vec3(Vec3::Zero());
  double resists = 1;  // over u
  if (!sums_passed(job) && grain_felt(job, material)) {
    resists = grain_resists(job, material,
                            motion.turning ? motion.grain->across2(s) : motion.across2, late);
    part.feel();
    part.felt_volume[axis] += resists * length;
    part.felt_moment[axis] += resists * length * r;
  }
  if (!motion.turning) return;
  const double s2 = s.squaredNorm();
  if (!(s2 > 0)) return;
  const double weight = resists * length * (s[ti] * s[ti]) / s2;
  const Vec3 f = (weight / s2) * s;
  RemovedPart::TurnSums& turn = part.turn();
  turn.force[axis] += f;
  turn.moment[axis] += r.cross(f);
  turn.moment_axis[axis] += r.dot(motion.tool_axis) * motion.tool_axis.cross(f);
  turn.volume[axis] += weight;
}

void add_passed(TileJob& job, int row, int lane, uint8_t material, double passed, double passed_t2,
                double late) {
  const auto axis = static_cast<size_t>(job.rays.axis);
  const int ui = u_index(job.rays.axis), vi = v_index(job.rays.axis),
            ti = depth_index(job.rays.axis);
  const Motion& motion = *job.request.motion;
  RemovedPart& part = job.removed->part(material);
  const double resists =
      grain_felt(job, material) ? grain_resists(job, material, motion.across2, late) : 1;
  part.feel();
  part.passed = true;
  part.felt_volume[axis] += resists * passed;
  Vec3& moment = part.felt_moment[axis];
  moment[ui] += resists * passed * (job.rays.u0 + lane + 0.5 - motion.reference[ui]);
  moment[vi] += resists * passed * (job.rays.v0 + row + 0.5 - motion.reference[vi]);
  moment[ti] +=
      resists *
      (0.5 * passed_t2 + passed * (static_cast<double>(job.request.t_ref) - motion.reference[ti]));
}

// A deposit that was cut off at the lattice's border ends in a face square to the ray, whatever the
// tool's surface.
static void face_lattice(TileJob& job) {
  const auto depth = static_cast<float>(job.request.field->nodes_depth());
  for (int slot = 0; slot < kTileRays; slot++) {
    if (!((job.spans.rows >> (slot / kTileSide)) & 1)) continue;
    if (job.spans.lo[slot] == 0) job.spans.codes.lo[slot] = 0;
    if (job.spans.hi[slot] == depth) job.spans.codes.hi[slot] = 0;
  }
}

void flush_sums(TileJob& job) {
  if (job.sums.material == kMixedMaterial) return;
  const auto axis = static_cast<size_t>(job.rays.axis);
  const auto u = u_index(job.rays.axis), v = v_index(job.rays.axis), t = depth_index(job.rays.axis);
  RemovedPart& part = job.removed->part(job.sums.material);
  using S = LaneSums;
  LaneTotals sum;
  HWY_DYNAMIC_DISPATCH(ReduceSums)(job.sums, sum);
  const LatticePoint& ref = job.request.motion->reference;
  // Of the four sums from `of` on.
  const auto add = [&](double& volume, Vec3& moment, size_t of, double times) {
    const double lengths = sum.of[of];
    volume += times * lengths;
    moment[u] += times * (sum.by_lane[of] + sum.of[of + 1] + lengths * (0.5 - ref[u]));
    moment[v] += times * (sum.of[of + 2] + lengths * (0.5 - ref[v]));
    moment[t] += times * (0.5 * sum.of[of + 3] +
                          lengths * (static_cast<double>(job.request.t_ref) - ref[t]));
  };
  add(part.volume[axis], part.moment[axis], S::length, 1);
  if (const bool passed = sums_passed(job); passed || grain_felt(job, job.sums.material)) {
    const Motion& motion = *job.request.motion;
    part.feel();
    part.passed |= passed;
    add(part.felt_volume[axis], part.felt_moment[axis], S::felt,
        grain_felt(job, job.sums.material)
            ? motion.grain->by_direction(job.sums.material, motion.across2)
            : 1);
  }
  if (job.rays.axis == Axis::z) {
    const double n = sum.of[S::nodes];
    part.points += static_cast<int64_t>(n);
    part.node_sum[static_cast<size_t>(u)] +=
        static_cast<int64_t>(sum.by_lane[S::nodes] + sum.of[S::nodes_u0]);
    part.node_sum[static_cast<size_t>(v)] += static_cast<int64_t>(sum.of[S::nodes_v]);
    part.node_sum[static_cast<size_t>(t)] += static_cast<int64_t>(
        0.5 * sum.of[S::nodes_t2] + n * static_cast<double>(job.request.t_ref));
  }
}

// Clipped to the lattice, an end may be nobody's any more: square to the ray, unless the solid says
// otherwise.
static void clear_codes(SpanLayer& layer, unsigned rows) {
  for (unsigned left = rows; left; left &= left - 1) {
    const int slot = __builtin_ctz(left) * kTileSide;
    std::fill_n(layer.codes.lo + slot, kTileSide, 0u);
    std::fill_n(layer.codes.hi + slot, kTileSide, 0u);
  }
}

// The rays the vectors left over.
static void edit_scalar_rays(TileJob& job, Tile& tile, bool growing) {
  for (int row = 0; row < kTileSide; row++)
    for (unsigned bits = job.scalar.rows[row]; bits; bits &= bits - 1) {
      const int lane = __builtin_ctz(bits), slot = row * kTileSide + lane;
      const float a = job.spans.lo[slot], b = job.spans.hi[slot];
      // What ended there before, a deposit does not end: as the vectors have it.
      unsigned had_a = 0, had_b = 0;
      for (const Plane* p = &tile.first; growing && p && !p->empty_at(slot); p = p->next) {
        had_a |= p->in[slot] == a;
        had_b |= p->out[slot] == b;
      }
      if (growing)
        deposit_ray(*job.request.field, tile, slot, a, b, job.request.material);
      else
        cut_ray(*job.request.field, tile, slot, a, b);
      // The ends the tool made are those at exactly a and b.
      for (const Plane* p = &tile.first; p && !p->empty_at(slot); p = p->next) {
        const unsigned at_a = (growing ? p->in : p->out)[slot] == a,
                       at_b = (growing ? p->out : p->in)[slot] == b;
        job.ends.mark(static_cast<size_t>(row), (at_a & ~had_a) << lane, (at_b & ~had_b) << lane);
      }
    }
  for (Plane* p = &tile.first; p; p = p->next) p->tight = false;
  job.shrank |= growing;  // a cut leaves only splits over, a deposit may join spans
}

void take_sums(TileJob& job) {
  flush_sums(job);
  HWY_DYNAMIC_DISPATCH(ClearSums)(job.sums);
  job.sums.material = job.sums_material;
}

TileKernel tile_kernel() {
  choose_vector_unit();
  return HWY_DYNAMIC_DISPATCH(RunVectors);
}

void run_tile(TileJob& job) {
  const Operation operation = job.request.operation;
  job.writable = nullptr;
  if (operation == Operation::paint) return job.request.kernel(job);
  const bool growing = operation == Operation::deposit || operation == Operation::deposit_contact;
  job.sums_material = growing ? job.request.material : job.tile->material;
  job.met = job.shrank = false;
  job.gaps = 0;
  job.request.kernel(job);
  if (!job.met || operation == Operation::contact || operation == Operation::deposit_contact)
    return;

  Tile& tile = *job.writable;
  tile.hash.store(0, std::memory_order_relaxed);
  if (job.scalar.any) {
    edit_scalar_rays(job, tile, growing);
    job.scalar = {};
  }
  if (growing) {
    tile.material =
        tile.empty || tile.material == job.request.material ? job.request.material : kMixedMaterial;
    tile.empty = false;
  }
  if (job.ends.rows) {
    const unsigned unknown = job.ends.rows & ~job.spans.normals_ready;
    if (unknown) {
      if (growing) clear_codes(job.spans, unknown);
      job.request.solid->normals(job.rays, job.layer, job.ends, job.spans);
    }
    if (growing) face_lattice(job);
    HWY_DYNAMIC_DISPATCH(StoreNormals)(job, !growing);
    job.ends = {};
  }
  if (job.shrank) {
    job.request.field->trim_planes(tile);
    if (tile.empty) job.request.field->clear_tile(job.tu, job.tv);
  }
}

}  // namespace kibori
#endif
