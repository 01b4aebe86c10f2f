// SPDX-License-Identifier: MIT
// The inner loop of every edit. A cut applies the tool's interval [a, b) to a ray's span [in, out).
// There are four cases:
//
//   a══in══b── out        front     masked store: in = b
//   in ──a══out══b        back      masked store: out = a
//   in ──a══════b── out   split     masked stores, here and in the next plane if free; else scalar
//   a══in══out══b         vanish    masked store; later planes then move up
//
// So vector code does nearly all of the work. It adds up what is removed row by row, before it
// writes the row. The order of additions does not depend on the vector's width. The sums need the
// normals of the tool's ends in material, so the solid computes these first. For tools with one
// interval per ray, cut and contact give the same result to the bit. If a solid has several layers,
// a cut applies its second layer to the result of the first, but contact to the original tile. Then
// the order of additions differs.
#include <kibori/edit/tile_kernel.h>

#include <cmath>

#include <kibori/base/vector_unit.h>
#include <kibori/dexel/volume.h>
#include <kibori/edit/ray_edit.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kibori/edit/tile_kernel.cpp"
#include <hwy/foreach_target.h>
#include <kibori/base/lanes-inl.h>

#ifndef KIBORI_TILE_KERNEL_SHARED
#define KIBORI_TILE_KERNEL_SHARED
namespace kibori {

// Sums of all lanes; `by_lane`: each lane weighted by its index.
struct LaneTotals {
  double of[LaneSums::kCount], by_lane[LaneSums::kCount];
};

// True if the sums need the scalar path: the tool turns, the tile has several materials, or the
// tool is too deep for exact float32 sums.
inline bool scalar_sums(const TileJob& job) {
  return job.request.motion->turning || job.sums_material == kMixedMaterial ||
         (job.request.deep && job.rays.axis == Axis::z);
}
inline bool has_grain(const TileJob& job, uint8_t material) {
  const Grain* const grain = job.request.motion->grain;
  return grain && grain->has_effect(material);
}
inline bool is_growing(Operation operation) {
  return operation == Operation::deposit || operation == Operation::deposit_contact;
}
// Makes the solid fill in the normals at the ends marked in `job.ends`, and clears the marks.
void request_normals(TileJob& job);
// Makes the tile writable. Copies it if a snapshot shares it.
inline void make_writable(TileJob& job) {
  job.tile = job.writable = &job.request.field->writable(job.tu, job.tv);
}
// An overlap marks cells in ChipSums::cells if it is longer than this [cells]. A shorter one may be
// rounding error.
inline constexpr float kMinMet = 0.02f;
// The indices of rows as floats, so that a vector can load them.
inline constexpr float kRowNumber[kTileSide] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                8, 9, 10, 11, 12, 13, 14, 15};

// One overlap [lo, hi) of one ray, the weights of its ends, and whether the ends are the tool's.
// `added`: it is a deposit's whole interval. Its overlaps with existing spans are subtracted from
// it.
struct Overlap {
  float lo, hi, weight_lo, weight_hi;
  bool tool_lo, tool_hi;
  bool added = false;
};
// The kind of an end that is tied to a node of a ray along x or y. material: it vanishes. tool: it
// is new. met: an end of the material that a deposit touches exactly.
enum class EndOf : uint8_t { material, tool, met };
inline EndOf end_of(bool by_tool, bool added) {
  return by_tool ? EndOf::tool : added ? EndOf::met : EndOf::material;
}
// True if the piece that is removed or added holds node k, to which its end is tied
// (dexel/volume.h). For an end that vanishes, the z field before the edit decides. For a new end,
// the z field after the edit decides. So the removed volumes add up to the missing volume.
// `material`: of the end that vanishes, or of the span that the tool shortens. The end is at
// `depth`. `at_hi`: it is the upper end of the piece.
bool holds_node(TileJob& job, int row, int lane, int k, EndOf end, int material, float depth,
                bool at_hi);
// Adds an overlap to the sums on the scalar path (scalar_sums). `sign`: 1 adds, -1 subtracts.
// `late`: mean of late_wood over the overlap.
void add_overlap(TileJob& job, int row, int lane, const Overlap& overlap, uint8_t material,
                 int sign, double late);
// Direction of a motion that does not turn, in the field's order u, v, depth; zero at rest.
struct FieldDirection {
  float u, v, t;
};
FieldDirection direction_in_field(const TileJob& job);

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

// The quantities that are summed for each overlap [lo, hi).
enum Summed : unsigned {
  kNothing = 0,
  kCorrections = 1,
  kNodes = 2,
  kWeighted = 4,
  kLengths = 8  // instead of corrections and nodes: see Motion::along
};

// Means of late_wood over the overlaps of `count` rays of a row, from the lane `at` on.
HWY_INLINE void LateWood(const TileJob& job, size_t row, size_t at, const float* lo,
                         const float* hi, size_t count, float* late) {
  const float u = static_cast<float>(job.rays.u0) + static_cast<float>(at) + 0.5f,
              v = static_cast<float>(job.rays.v0) + static_cast<float>(row) + 0.5f;
  job.request.motion->grain->late_wood_of(job.rays.axis, u, v, lo, hi, count, late);
}

// The sum of the squares of a normal code's two components.
HWY_INLINE VU SumOfSquares(VU code) {
  const DI di;
  const DU du;
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR
  const hn::Repartition<int16_t, DI> d16;
  const auto parts = hn::BitCast(d16, code);
  VI unused = hn::Zero(di);  // on x86, the first sum holds both products
  return hn::BitCast(du, hn::ReorderWidenMulAccumulate(di, parts, parts, hn::Zero(di), unused));
#else
  const VI both = hn::BitCast(di, code), u = hn::ShiftRight<16>(hn::ShiftLeft<16>(both)),
           v = hn::ShiftRight<16>(both);
  return hn::Add(hn::BitCast(du, hn::Mul(u, u)), hn::BitCast(du, hn::Mul(v, v)));
#endif
}

// depth_weight of normal_code.h.
HWY_INLINE VF DepthWeight(VU code) {
  const DF d;
  const VI half = hn::BitCast(DI(), hn::ShiftRight<1>(SumOfSquares(code)));
  return hn::Max(hn::Zero(d), hn::Sub(F(1.0f), hn::Mul(F(kHalfSquares), hn::ConvertTo(d, half))));
}

// Overlaps of the rays of a row, the weights of their ends, and which of the ends are the tool's.
struct Overlaps {
  VF lo, hi, weight_lo, weight_hi;
  MF tool_lo, tool_hi;
  const Plane* plane = nullptr;  // of the spans; null for a deposit's whole interval
};

// Overlaps between the tool's intervals [a, b) and the spans [in, out) of a plane, at a slot. An
// end that both share counts as the material's in a cut, because it vanishes. In a deposit, it
// counts as the tool's. Then its correction cancels the one at that end of the whole interval.
HWY_INLINE Overlaps OverlapsAt(const SpanLayer& tool, const Plane& plane, size_t slot, VF a, VF b,
                               VF in, VF out, bool growing = false) {
  const DU du;
  const auto weight = [&](MF by_tool, const uint32_t* own, const uint32_t* material) HWY_ATTR {
    return DepthWeight(hn::IfThenElse(hn::RebindMask(du, by_tool), hn::Load(du, own + slot),
                                      hn::Load(du, material + slot)));
  };
  const MF tool_lo = growing ? hn::Ge(a, in) : hn::Gt(a, in),
           tool_hi = growing ? hn::Le(b, out) : hn::Lt(b, out);
  return {hn::Max(in, a),
          hn::Min(out, b),
          weight(tool_lo, tool.codes.lo, plane.normal_in),
          weight(tool_hi, tool.codes.hi, plane.normal_out),
          tool_lo,
          tool_hi,
          &plane};
}

// If an end of a deposit is exactly at an end of the same material, both vanish. The correction
// there uses the normal of the material's end. If another span touches this end already, nothing
// changes there.
HWY_INLINE void MeetEnds(const TileJob& job, size_t slot, Overlaps& added) {
  const DF d;
  const DU du;
  const Plane* const planes = &job.tile->first;
  MF covered_lo = hn::FirstN(d, 0), covered_hi = covered_lo;
  for (const Plane* p = planes; p; p = p->next) {
    covered_lo = hn::Or(covered_lo, hn::Eq(hn::Load(d, p->in + slot), added.lo));
    covered_hi = hn::Or(covered_hi, hn::Eq(hn::Load(d, p->out + slot), added.hi));
  }
  const bool mixed = job.tile->material != job.request.material;
  for (const Plane* p = planes; p; p = p->next) {
    MF below = hn::AndNot(covered_lo, hn::Eq(hn::Load(d, p->out + slot), added.lo)),
       above = hn::AndNot(covered_hi, hn::Eq(hn::Load(d, p->in + slot), added.hi));
    if (hn::AllFalse(d, hn::Or(below, above))) continue;
    if (mixed) {
      unsigned same = 0;
      for (size_t lane = 0; lane < kLanes; lane++)
        same |= (p->material[slot + lane] == job.request.material ? 1u : 0u) << lane;
      below = hn::And(below, FromBits(same));
      above = hn::And(above, FromBits(same));
    }
    added.weight_lo =
        hn::IfThenElse(below, DepthWeight(hn::Load(du, p->normal_out + slot)), added.weight_lo);
    added.weight_hi =
        hn::IfThenElse(above, DepthWeight(hn::Load(du, p->normal_in + slot)), added.weight_hi);
    added.tool_lo = hn::AndNot(below, added.tool_lo);
    added.tool_hi = hn::AndNot(above, added.tool_hi);
  }
}

// Returns `nodes` with new values in the lanes that are `tied`: the first node at lower ends, or
// the node after the last one at upper ends.
HWY_NOINLINE VF TiedNodes(TileJob& job, size_t row, size_t g, MF tied, VF depth, MF by_tool,
                          const Plane* plane, bool at_hi, VF nodes) {
  const DF d;
  alignas(64) float depths[kLanes], to[kLanes];
  hn::Store(depth, d, depths);
  hn::Store(nodes, d, to);
  const unsigned tool = Bits(by_tool);
  for (unsigned left = Bits(tied); left; left &= left - 1) {
    const auto lane = static_cast<size_t>(__builtin_ctz(left));
    const int k = tied_node(depths[lane]);
    const size_t across = g * kLanes + lane;
    const bool holds = holds_node(
        job, static_cast<int>(row), static_cast<int>(across), k, end_of((tool >> lane) & 1, !plane),
        plane ? plane->material[row * kTileSide + across] : job.request.material, depths[lane],
        at_hi);
    to[lane] = static_cast<float>(holds == at_hi ? k + 1 : k);
  }
  return hn::Load(d, to);
}

// The nodes k0 <= k < k1 that overlaps hold. Valid in the lanes `hit`.
struct Nodes {
  VF k0, k1;
};
HWY_INLINE Nodes NodesOf(TileJob& job, size_t row, size_t g, MF hit, const Overlaps& at,
                         bool along_z) {
  // Nodes k with lo <= k + 1/2 < hi. All sums are whole numbers below 2^24, because `deep` tools
  // take the scalar path.
  Nodes n{hn::Ceil(hn::Sub(at.lo, F(0.5f))), hn::Ceil(hn::Sub(at.hi, F(0.5f)))};
  if (along_z) return n;
  // is_tied of volume.h.
  const DF d;
  const VF off_lo = hn::Abs(hn::Sub(n.k0, at.lo)), off_hi = hn::Abs(hn::Sub(n.k1, at.hi)),
           tied = F(0.5f - kTie);
  if (HWY_UNLIKELY(!hn::AllFalse(d, hn::Gt(hn::Max(off_lo, off_hi), tied))) && job.request.z) {
    const auto lanes = [&](VF off, VF weight) HWY_ATTR {
      return hn::And(hit, hn::And(hn::Gt(off, tied), hn::Gt(weight, F(kTiedWeight))));
    };
    n.k0 = TiedNodes(job, row, g, lanes(off_lo, at.weight_lo), at.lo, at.tool_lo, at.plane, false,
                     n.k0);
    n.k1 = TiedNodes(job, row, g, lanes(off_hi, at.weight_hi), at.hi, at.tool_hi, at.plane, true,
                     n.k1);
  }
  return n;
}

// Sums over one tile's rows, in registers.
template <unsigned kSummed>
struct Sums {
  VF correction, correction_v, correction_t2, nodes, nodes_v, nodes_t2;
  VF weighted, weighted_v, weighted_t2;

  HWY_INLINE Sums() {
    correction = correction_v = correction_t2 = nodes = nodes_v = nodes_t2 = hn::Zero(DF());
    weighted = weighted_v = weighted_t2 = hn::Zero(DF());
  }
  // Adds the overlaps in the lanes `hit`; `twice_ref` is 2 t_ref.
  HWY_INLINE void Add(TileJob& job, size_t at_row, size_t g, MF hit, const Overlaps& at,
                      VF twice_ref) {
    if constexpr (kSummed == kNothing) return;
    const VF row = F(kRowNumber[at_row]);
    if constexpr ((kSummed & kLengths) != 0) {
      const VF length = hn::IfThenElseZero(hit, hn::Sub(at.hi, at.lo));
      const VF length_t2 =
          hn::IfThenElseZero(hit, hn::Mul(length, hn::Sub(hn::Add(at.lo, at.hi), twice_ref)));
      correction = hn::Add(correction, length);
      correction_v = hn::Add(correction_v, hn::Mul(length, row));
      correction_t2 = hn::Add(correction_t2, length_t2);
      return AddWeighted(job, at_row, g, hit, at, length, length_t2);
    }
    const auto [k0, k1] = NodesOf(job, at_row, g, hit, at, (kSummed & kNodes) != 0);
    const VF by_lo = hn::Mul(at.weight_lo, hn::Sub(k0, at.lo)),
             by_hi = hn::Mul(at.weight_hi, hn::Sub(at.hi, k1));
    const VF more = hn::IfThenElseZero(hit, hn::Add(by_lo, by_hi));
    // A correction acts half way between the cell's boundary and the end.
    const VF more_t2 =
        hn::IfThenElseZero(hit, hn::Add(hn::Mul(by_lo, hn::Sub(hn::Add(k0, at.lo), twice_ref)),
                                        hn::Mul(by_hi, hn::Sub(hn::Add(k1, at.hi), twice_ref))));
    correction = hn::Add(correction, more);
    correction_v = hn::Add(correction_v, hn::Mul(more, row));
    correction_t2 = hn::Add(correction_t2, more_t2);
    VF all = more, all_t2 = more_t2;
    if constexpr ((kSummed & kNodes) != 0) {
      const VF n = hn::IfThenElseZero(hit, hn::Sub(k1, k0));
      const VF n_t2 = hn::Mul(n, hn::Sub(hn::Sub(hn::Add(k0, k1), F(1.0f)), twice_ref));
      nodes = hn::Add(nodes, n);
      nodes_v = hn::Add(nodes_v, hn::Mul(n, row));
      nodes_t2 = hn::Add(nodes_t2, n_t2);
      if constexpr ((kSummed & kWeighted) != 0) {
        // The middle of nodes k0 .. k1 - 1 is at (k0 + k1) / 2.
        all = hn::Add(all, n);
        all_t2 = hn::Add(all_t2, hn::Add(n_t2, n));
      }
    }
    AddWeighted(job, at_row, g, hit, at, all, all_t2);
  }
  // Adds `all`, weighted by the rings in each overlap. `all_t2`: `all` times twice the depth.
  HWY_INLINE void AddWeighted(const TileJob& job, size_t row, size_t g, MF hit, const Overlaps& at,
                              VF all, VF all_t2) {
    if constexpr ((kSummed & kWeighted) == 0) return;
    const VF by = Resistance(job, row, g, hit, at.lo, at.hi), more = hn::Mul(all, by);
    weighted = hn::Add(weighted, more);
    weighted_v = hn::Add(weighted_v, hn::Mul(more, F(kRowNumber[row])));
    weighted_t2 = hn::Add(weighted_t2, hn::Mul(all_t2, by));
  }
  // Ratio of the resistance to u, from the rings in each overlap.
  static HWY_INLINE VF Resistance(const TileJob& job, size_t row, size_t g, MF hit, VF lo, VF hi) {
    const DF d;
    const auto ring = static_cast<float>(job.request.motion->grain->ring(job.sums_material));
    if (ring == 0 || hn::AllFalse(d, hit)) return F(1.0f);
    alignas(64) float los[kLanes], his[kLanes], late[kLanes];
    hn::Store(lo, d, los);
    hn::Store(hi, d, his);
    LateWood(job, row, g * kLanes, los, his, kLanes, late);
    return hn::IfThenElse(
        hit,
        hn::Add(F(1.0f),
                hn::Mul(F(ring), hn::Sub(hn::Load(d, late), F(static_cast<float>(kMeanLate))))),
        F(1.0f));
  }
  HWY_INLINE void AddTo(TileJob& job, size_t g, bool negative) const {
    if constexpr (kSummed == kNothing) return;
    if (job.sums.material != job.sums_material) take_sums(job);
    LaneSums& to = job.sums;
    const RayTile& rays = job.rays;
    const double sign = negative ? -1 : 1, u0 = sign * rays.u0, v0 = sign * rays.v0;
    const size_t at = g * kLanes;
    // Adds a sum, the sum weighted by row, and the sum weighted by twice the depth. `of` is the
    // index of the first of four totals.
    const auto add = [&](size_t of, VF sum, VF by_v, VF by_t2) HWY_ATTR {
      AddDoubles(to.of[of] + at, sum, sign);
      AddDoubles(to.of[of + 1] + at, sum, u0);
      AddDoubles(to.of[of + 2] + at, sum, v0);
      AddDoubles(to.of[of + 2] + at, by_v, sign);
      AddDoubles(to.of[of + 3] + at, by_t2, sign);
    };
    add(LaneSums::correction, correction, correction_v, correction_t2);
    if constexpr ((kSummed & kWeighted) != 0)
      add(LaneSums::weighted, weighted, weighted_v, weighted_t2);
    if constexpr ((kSummed & kNodes) != 0) add(LaneSums::nodes, nodes, nodes_v, nodes_t2);
  }
};

// Sums for the shape of the chip, over one tile: a separate pass over the overlaps, before the tile
// is written.
class ChipPass {
 public:
  explicit ChipPass(TileJob& job)
      : job_(job), along_z_(job.rays.axis == Axis::z), lengths_(job.request.motion->along) {}

  void Run(bool growing) {
    const DF d;
    const DU du;
    for (size_t g = 0; g < kGroups; g++) {
      Clear();
      bool met = false;
      for (unsigned left = job_.spans.rows; left; left &= left - 1) {
        const auto row = static_cast<size_t>(__builtin_ctz(left));
        const size_t slot = row * kTileSide + g * kLanes;
        const VF a = hn::Load(d, job_.spans.lo + slot), b = hn::Load(d, job_.spans.hi + slot);
        MF lanes = hn::Lt(a, b);
        if (growing) {
          lanes = FromBits((job_.adds[row] >> (g * kLanes)) & kGroupMask);
          Overlaps all{a,
                       b,
                       DepthWeight(hn::Load(du, job_.spans.codes.lo + slot)),
                       DepthWeight(hn::Load(du, job_.spans.codes.hi + slot)),
                       lanes,
                       lanes};
          MeetEnds(job_, slot, all);
          if (hn::AllFalse(d, lanes)) continue;
          met = true;
          Add(row, g, lanes, all, 1);
        }
        for (const Plane* p = &job_.tile->first; p; p = p->next) {
          const VF in = hn::Load(d, p->in + slot), out = hn::Load(d, p->out + slot);
          const MF hit = hn::And(lanes, hn::Lt(hn::Max(in, a), hn::Min(out, b)));
          if (hn::AllFalse(d, hit)) continue;
          met = true;
          const Overlaps at = OverlapsAt(job_.spans, *p, slot, a, b, in, out, growing);
          Add(row, g, hit, at, growing ? -1 : 1);
          if (!growing && !lengths_) AddFront(slot, hit, at);
        }
      }
      if (met) AddTo(g);
    }
    if (growing) return;
    job_.chip_cells[static_cast<size_t>(u_index(job_.rays.axis))].add16(job_.rays.u0, lanes_met_);
    job_.chip_cells[static_cast<size_t>(v_index(job_.rays.axis))].add16(job_.rays.v0, rows_met_);
  }

 private:
  void Clear() {
    for (VF* sum : {&x_, &x_v_, &x_t2_, &x_vv_, &x_vt2_, &x_t2t2_, &length_, &front_, &front_u_,
                    &front_v_, &front_t_})
      *sum = hn::Zero(DF());
  }
  HWY_INLINE void Add(size_t row, size_t g, MF hit, const Overlaps& at, float sign) {
    const DF d;
    const VF twice_ref = F(2 * job_.request.t_ref);
    VF x = hn::Zero(d), x_t2 = x, x_t2t2 = x;
    // Adds a volume that is spread evenly along the ray between two depths.
    const auto rod = [&](VF volume, VF lo, VF hi) HWY_ATTR {
      const VF twice = hn::Sub(hn::Add(lo, hi), twice_ref), length = hn::Sub(hi, lo),
               by_twice = hn::Mul(volume, twice);
      x = hn::Add(x, volume);
      x_t2 = hn::Add(x_t2, by_twice);
      x_t2t2 = hn::Add(x_t2t2, hn::Mul(by_twice, twice));
      x_t2t2 = hn::Add(x_t2t2, hn::Mul(hn::Mul(volume, F(1.0f / 3)), hn::Mul(length, length)));
    };
    if (lengths_) {
      rod(hn::Sub(at.hi, at.lo), at.lo, at.hi);
    } else {
      const auto [k0, k1] = NodesOf(job_, row, g, hit, at, along_z_);
      rod(hn::Mul(at.weight_lo, hn::Sub(k0, at.lo)), at.lo, k0);
      rod(hn::Mul(at.weight_hi, hn::Sub(at.hi, k1)), k1, at.hi);
      if (along_z_) rod(hn::Sub(k1, k0), k0, k1);
    }
    const VF length = hn::Sub(at.hi, at.lo);
    length_ = hn::Add(length_, hn::IfThenElseZero(hit, hn::Mul(length, F(sign))));
    if (const unsigned met = Bits(hn::And(hit, hn::Gt(length, F(kMinMet))))) {
      lanes_met_ |= met << (g * kLanes);
      rows_met_ |= 1u << row;
    }
    x = hn::IfThenElseZero(hit, hn::Mul(x, F(sign)));
    x_t2 = hn::IfThenElseZero(hit, hn::Mul(x_t2, F(sign)));
    const VF v = F(static_cast<float>(job_.rays.v0) - job_.request.v_ref + kRowNumber[row] + 0.5f),
             x_v = hn::Mul(x, v);
    x_ = hn::Add(x_, x);
    x_v_ = hn::Add(x_v_, x_v);
    x_vv_ = hn::Add(x_vv_, hn::Mul(x_v, v));
    x_t2_ = hn::Add(x_t2_, x_t2);
    x_vt2_ = hn::Add(x_vt2_, hn::Mul(x_t2, v));
    x_t2t2_ = hn::Add(x_t2t2_, hn::IfThenElseZero(hit, hn::Mul(x_t2t2, F(sign))));
  }
  // The codes are those of the remaining material, which ends where the tool begins. The tool's
  // normals are the opposite.
  HWY_INLINE void AddFront(size_t slot, MF hit, const Overlaps& at) {
    const DU du;
    const DI di;
    const DF d;
    const FieldDirection p = direction_in_field(job_);
    const auto add = [&](MF by_tool, const uint32_t* codes, VF weight, float sign_t) HWY_ATTR {
      const MF lanes = hn::And(hit, by_tool);
      if (hn::AllFalse(d, lanes)) return;
      const VI code = hn::BitCast(di, hn::Load(du, codes + slot));
      const VF scale = F(-1 / 32767.0f), size = hn::Sqrt(weight);
      const VF u = hn::Mul(hn::ConvertTo(d, hn::ShiftRight<16>(hn::ShiftLeft<16>(code))), scale),
               v = hn::Mul(hn::ConvertTo(d, hn::ShiftRight<16>(code)), scale),
               t = hn::Mul(size, F(sign_t));
      const VF ahead = hn::Add(hn::Add(hn::Mul(u, F(p.u)), hn::Mul(v, F(p.v))), hn::Mul(t, F(p.t)));
      const VF area = hn::IfThenElseZero(lanes, hn::Mul(size, hn::Max(hn::Zero(d), ahead)));
      front_ = hn::Add(front_, area);
      front_u_ = hn::Add(front_u_, hn::Mul(area, u));
      front_v_ = hn::Add(front_v_, hn::Mul(area, v));
      front_t_ = hn::Add(front_t_, hn::Mul(area, t));
    };
    add(at.tool_lo, job_.spans.codes.lo, at.weight_lo, -1);
    add(at.tool_hi, job_.spans.codes.hi, at.weight_hi, 1);
  }
  void AddTo(size_t g) {
    if (job_.sums.material != job_.sums_material) take_sums(job_);
    const VF u = LanesFrom(static_cast<float>(job_.rays.u0) - job_.request.u_ref + 0.5f, g);
    const VF x_u = hn::Mul(x_, u);
    const auto add = [&](ChipLanes::Of of, VF sum)
                         HWY_ATTR { AddDoubles(job_.chip.of[of] + g * kLanes, sum, 1); };
    add(ChipLanes::uu, hn::Mul(x_u, u));
    add(ChipLanes::uv, hn::Mul(x_v_, u));
    add(ChipLanes::vv, x_vv_);
    add(ChipLanes::ut2, hn::Mul(x_t2_, u));
    add(ChipLanes::vt2, x_vt2_);
    add(ChipLanes::t2t2, x_t2t2_);
    if (lengths_) return;
    add(ChipLanes::length, length_);
    add(ChipLanes::front, front_);
    add(ChipLanes::front_u, front_u_);
    add(ChipLanes::front_v, front_v_);
    add(ChipLanes::front_t, front_t_);
  }

  TileJob& job_;
  const bool along_z_;
  const bool lengths_;
  unsigned lanes_met_ = 0, rows_met_ = 0;
  VF x_, x_v_, x_t2_, x_vv_, x_vt2_, x_t2t2_, length_, front_, front_u_, front_v_, front_t_;
};

// The sums of tiles for which scalar_sums() is true: overlaps of cuts, or what a deposit adds. It
// adds row by row, plane by plane and lane by lane, so the order of additions does not depend on
// the vector's width.
void AddScalarSums(TileJob& job, bool growing) {
  const DF d;
  alignas(64) float los[kRow], his[kRow], weights_lo[kRow], weights_hi[kRow], late[kRow];
  const bool grained = job.request.motion->grain != nullptr;
  for (unsigned left = job.spans.rows; left; left &= left - 1) {
    const int row = __builtin_ctz(left);
    const size_t first = static_cast<size_t>(row) * kTileSide;
    const float *a = job.spans.lo + first, *b = job.spans.hi + first;
    const unsigned adds = growing ? job.adds[row] : ~0u;
    if (growing && adds) {
      if (grained) LateWood(job, static_cast<size_t>(row), 0, a, b, kRow, late);
      for (unsigned lanes = adds; lanes; lanes &= lanes - 1) {
        const auto lane = static_cast<size_t>(__builtin_ctz(lanes));
        const size_t slot = first + lane;
        Overlap all{a[lane],
                    b[lane],
                    depth_weight(job.spans.codes.lo[slot]),
                    depth_weight(job.spans.codes.hi[slot]),
                    true,
                    true,
                    true};
        // The same rule as in MeetEnds.
        bool covered_lo = false, covered_hi = false;
        for (const Plane* p = &job.tile->first; p; p = p->next) {
          covered_lo |= p->in[slot] == all.lo;
          covered_hi |= p->out[slot] == all.hi;
        }
        for (const Plane* p = &job.tile->first; p; p = p->next) {
          if (p->material[slot] != job.request.material) continue;
          if (!covered_lo && p->out[slot] == all.lo) {
            all.weight_lo = depth_weight(p->normal_out[slot]);
            all.tool_lo = false;
          }
          if (!covered_hi && p->in[slot] == all.hi) {
            all.weight_hi = depth_weight(p->normal_in[slot]);
            all.tool_hi = false;
          }
        }
        add_overlap(job, row, static_cast<int>(lane), all, job.request.material, 1,
                    grained ? late[lane] : 0);
      }
    }
    for (const Plane* p = &job.tile->first; p; p = p->next) {
      unsigned hits = 0, tool_lo = 0, tool_hi = 0;
      for (size_t g = 0; g < kGroups; g++) {
        const size_t at = g * kLanes, slot = first + at;
        const Overlaps overlaps =
            OverlapsAt(job.spans, *p, slot, hn::Load(d, a + at), hn::Load(d, b + at),
                       hn::Load(d, p->in + slot), hn::Load(d, p->out + slot), growing);
        hn::Store(overlaps.lo, d, los + at);
        hn::Store(overlaps.hi, d, his + at);
        hn::Store(overlaps.weight_lo, d, weights_lo + at);
        hn::Store(overlaps.weight_hi, d, weights_hi + at);
        hits |= Bits(hn::Lt(overlaps.lo, overlaps.hi)) << at;
        tool_lo |= Bits(overlaps.tool_lo) << at;
        tool_hi |= Bits(overlaps.tool_hi) << at;
      }
      hits &= adds;
      if (hits && grained) LateWood(job, static_cast<size_t>(row), 0, los, his, kRow, late);
      for (; hits; hits &= hits - 1) {
        const int lane = __builtin_ctz(hits);
        add_overlap(job, row, lane,
                    {los[lane], his[lane], weights_lo[lane], weights_hi[lane],
                     ((tool_lo >> lane) & 1) != 0, ((tool_hi >> lane) & 1) != 0},
                    p->material[first + static_cast<size_t>(lane)], growing ? -1 : 1,
                    grained ? late[lane] : 0);
      }
    }
  }
}

// Marks the tool's ends in material whose normals the solid has not filled in yet. Returns false if
// the tool meets nothing.
bool MarkEndsInMaterial(TileJob& job) {
  const DF d;
  const SpanLayer& spans = job.spans;
  // Calls f(row, g, at_lo, at_hi) for each group of lanes in which the tool meets a plane's spans,
  // until f returns true. at_lo and at_hi: lanes in which the tool has its end in material.
  const auto meetings = [&](unsigned left, auto&& f) HWY_ATTR {
    for (; left; left &= left - 1) {
      const auto row = static_cast<size_t>(__builtin_ctz(left));
      for (size_t g = 0; g < kGroups; g++) {
        const size_t slot = row * kTileSide + g * kLanes;
        const VF a = hn::Load(d, spans.lo + slot), b = hn::Load(d, spans.hi + slot);
        for (const Plane* p = &job.tile->first; p; p = p->next) {
          const VF in = hn::Load(d, p->in + slot), out = hn::Load(d, p->out + slot);
          const MF hit = hn::Lt(hn::Max(in, a), hn::Min(out, b));
          if (!hn::AllFalse(d, hit) &&
              f(row, g, hn::And(hit, hn::Gt(a, in)), hn::And(hit, hn::Lt(b, out))))
            return true;
        }
      }
    }
    return false;
  };
  bool meets = false;
  meetings(spans.rows & ~spans.normals_ready, [&](size_t row, size_t g, MF lo, MF hi) HWY_ATTR {
    meets = true;
    job.ends.mark(row, Bits(lo) << (g * kLanes), Bits(hi) << (g * kLanes));
    return false;
  });
  return meets || meetings(spans.rows & spans.normals_ready,
                           [](size_t, size_t, MF, MF) HWY_ATTR { return true; });
}

// Finds the lanes in which a deposit adds material, and marks their ends. Returns false if there
// are none.
bool MarkAdds(TileJob& job) {
  const DF d;
  bool any = false;
  for (unsigned left = job.spans.rows; left; left &= left - 1) {
    const auto row = static_cast<size_t>(__builtin_ctz(left));
    unsigned adds = 0;
    for (size_t g = 0; g < kGroups; g++) {
      const size_t slot = row * kTileSide + g * kLanes;
      const VF a = hn::Load(d, job.spans.lo + slot), b = hn::Load(d, job.spans.hi + slot);
      const MF live = hn::Lt(a, b);
      if (hn::AllFalse(d, live)) continue;
      MF covered = hn::FirstN(d, 0);
      for (const Plane* p = &job.tile->first; p; p = p->next)
        covered = hn::Or(covered, hn::And(hn::Le(hn::Load(d, p->in + slot), a),
                                          hn::Ge(hn::Load(d, p->out + slot), b)));
      adds |= Bits(hn::AndNot(covered, live)) << (g * kLanes);
    }
    job.adds[row] = static_cast<uint16_t>(adds);
    job.ends.mark(row, adds, adds);
    any |= adds != 0;
  }
  return any;
}

// Computes the same sums as CutTile in the same order, and writes nothing.
template <unsigned kSummed>
void ContactCut(TileJob& job) {
  const DF d;
  const VF twice_ref = F(2 * job.request.t_ref);
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
        const MF hit = hn::Lt(hn::Max(in, a), hn::Min(out, b));
        if (hn::AllFalse(d, hit)) continue;
        met = hn::Or(met, hit);
        sum.Add(job, row, g, hit, OverlapsAt(job.spans, *p, slot, a, b, in, out), twice_ref);
      }
    }
    if (hn::AllFalse(d, met)) continue;
    job.met = true;
    sum.AddTo(job, g, false);
  }
}

// Stores normals for the ends that the tool made in `lanes` of a row, and clears their paint.
HWY_INLINE void GiveNormals(const TileJob& job, Plane& plane, size_t slot, MF lanes, bool at_in) {
  const DU du;
  const auto store = [&](VU what, uint32_t* to) HWY_ATTR {
    hn::BlendedStore(what, hn::RebindMask(du, lanes), du, to + slot);
  };
  // The remaining material begins where the tool ends, and ends where the tool begins.
  store(hn::Load(du, (at_in ? job.spans.codes.hi : job.spans.codes.lo) + slot),
        at_in ? plane.normal_in : plane.normal_out);
  if (plane.paint) store(hn::Zero(du), at_in ? plane.paint->in : plane.paint->out);
}

// Cuts a group of a row in which spans vanish or split.
HWY_NOINLINE void CutHardRow(TileJob& job, Plane& plane, size_t row, size_t g) {
  const DF d;
  const DU du;
  const size_t slot = row * kTileSide + g * kLanes;
  const VF a = hn::Load(d, job.spans.lo + slot), b = hn::Load(d, job.spans.hi + slot);
  const VF in = hn::Load(d, plane.in + slot), out = hn::Load(d, plane.out + slot);
  const MF hit = hn::Lt(hn::Max(in, a), hn::Min(out, b));
  const MF front = hn::And(hit, hn::Le(a, in)), back = hn::And(hit, hn::Ge(b, out));
  const MF trim_in = hn::AndNot(back, front), trim_out = hn::AndNot(front, back);
  hn::BlendedStore(b, trim_in, d, plane.in + slot);
  hn::BlendedStore(a, trim_out, d, plane.out + slot);
  GiveNormals(job, plane, slot, trim_in, true);
  GiveNormals(job, plane, slot, trim_out, false);
  unsigned hard = 0;
  const MF split = hn::AndNot(hn::Or(front, back), hit);
  if (!hn::AllFalse(d, split)) {
    // The part behind the tool moves to the next plane, if the ray has no span there.
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
    GiveNormals(job, plane, slot, room, false);
    GiveNormals(job, next, slot, room, true);
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

// Cuts a writable tile, plane by plane.
template <unsigned kSummed>
void CutTile(TileJob& job) {
  const DF d;
  const SpanLayer& spans = job.spans;
  const VF twice_ref = F(2 * job.request.t_ref);
  Plane* const first = &job.writable->first;
  uint64_t met_planes = 0;  // by index; planes from index 63 on share one bit
  for (size_t g = 0; g < kGroups; g++) {
    Sums<kSummed> sum;
    bool met_here = false;
    uint64_t number = 1;
    for (Plane* p = first; p; p = p->next, number = number << 1 | number >> 63 << 63) {
      if (!p->reaches(job.request.depth_min, job.request.depth_max)) continue;
      bool met = false;
      for (unsigned left = spans.rows; left; left &= left - 1) {
        const auto row = static_cast<size_t>(__builtin_ctz(left));
        const size_t slot = row * kTileSide + g * kLanes;
        const VF a = hn::Load(d, spans.lo + slot), b = hn::Load(d, spans.hi + slot);
        const VF in = hn::Load(d, p->in + slot), out = hn::Load(d, p->out + slot);
        const MF hit = hn::Lt(hn::Max(in, a), hn::Min(out, b));
        if (hn::AllFalse(d, hit)) continue;
        met = true;
        const Overlaps at = OverlapsAt(spans, *p, slot, a, b, in, out);
        sum.Add(job, row, g, hit, at, twice_ref);
        // The tool covers the span's beginning, its end, both, or neither.
        const MF front = hn::AndNot(at.tool_lo, hit), back = hn::AndNot(at.tool_hi, hit);
        if (!hn::AllFalse(d, hn::AndNot(hn::Xor(front, back), hit))) {
          CutHardRow(job, *p, row, g);
          continue;
        }
        if (!hn::AllFalse(d, front)) {
          hn::BlendedStore(b, front, d, p->in + slot);
          GiveNormals(job, *p, slot, front, true);
        }
        if (!hn::AllFalse(d, back)) {
          hn::BlendedStore(a, back, d, p->out + slot);
          GiveNormals(job, *p, slot, back, false);
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
  // Tightens the bounds of planes that were visited but not met, so that the next edit may skip
  // them.
  uint64_t number = 1;
  for (Plane* p = first; p; p = p->next, number = number << 1 | number >> 63 << 63)
    if (!p->tight && !(met_planes & number) &&
        p->reaches(job.request.depth_min, job.request.depth_max))
      Tighten(*p);
}

// A deposit, or its contact test. The added part is the tool's interval without the spans in it.
template <bool kWrite, unsigned kSummed>
void DepositTile(TileJob& job) {
  const DF d;
  const DU du;
  const VF twice_ref = F(2 * job.request.t_ref);
  const Plane* first = &job.tile->first;
  // The added part is within the solid's bounds and the lattice.
  const float min =
      std::max(job.request.depth_begin, static_cast<float>(job.request.depth_min) - 1);
  const float max = std::min(job.request.depth_end, static_cast<float>(job.request.depth_max) + 1);
  const auto grown = [&](Plane& plane) {
    plane.include(min, max);
    plane.tight = false;
  };
  for (size_t g = 0; g < kGroups; g++) {
    Sums<kSummed> sum, less;
    bool met = false;
    for (unsigned left = job.spans.rows; left; left &= left - 1) {
      const int row = __builtin_ctz(left);
      const unsigned add_bits = (job.adds[row] >> (g * kLanes)) & kGroupMask;
      if (!add_bits) continue;
      met = true;
      const MF adds = FromBits(add_bits);
      const size_t slot = static_cast<size_t>(row) * kTileSide + g * kLanes;
      const VF a = hn::Load(d, job.spans.lo + slot), b = hn::Load(d, job.spans.hi + slot);
      Overlaps all{a,
                   b,
                   DepthWeight(hn::Load(du, job.spans.codes.lo + slot)),
                   DepthWeight(hn::Load(du, job.spans.codes.hi + slot)),
                   adds,
                   adds};
      if (kSummed != kNothing) MeetEnds(job, slot, all);
      sum.Add(job, static_cast<size_t>(row), g, adds, all, twice_ref);
      MF touched = hn::FirstN(d, 0), twice = touched;
      for (const Plane* p = first; p; p = p->next) {
        const VF in = hn::Load(d, p->in + slot), out = hn::Load(d, p->out + slot);
        const MF touch = hn::And(adds, hn::And(hn::Le(in, b), hn::Le(a, out)));
        twice = hn::Or(twice, hn::And(touched, touch));
        touched = hn::Or(touched, touch);
        const MF hit = hn::And(adds, hn::Lt(hn::Max(in, a), hn::Min(out, b)));
        if (hn::AllFalse(d, hit)) continue;
        less.Add(job, static_cast<size_t>(row), g, hit,
                 OverlapsAt(job.spans, *p, slot, a, b, in, out, true), twice_ref);
      }
      if constexpr (kWrite) {
        if (!job.writable) {
          make_writable(job);
          first = &job.tile->first;
        }
        Plane* const own = &job.writable->first;
        // Vectors can handle a ray that is empty, or in which the deposit touches exactly one span.
        // All spans of the tile must have the deposit's material.
        const bool sole = job.tile->empty || job.tile->material == job.request.material;
        unsigned hard = add_bits;
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

// Stores the normals of the ends marked in `job.ends`. After a cut, material ends where the tool
// begins. After a deposit, it begins there.
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
        // With several planes, the end is in the plane with exactly this value.
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
      job.tile = job.writable = &job.request.field->maybe_writable(job.tu, job.tv);
      return CutTile<kSummed>(job);
    case Operation::contact:
      return ContactCut<kSummed>(job);
    case Operation::deposit:
      return DepositTile<true, kSummed>(job);
    case Operation::deposit_contact:
      return DepositTile<false, kSummed>(job);
    case Operation::paint:
      return;  // see RunVectors
  }
}

void ClearSums(TileJob& job) {
  const hn::CappedTag<double, 8> d;
  const auto clear = [&](auto& sums) HWY_ATTR {
    for (auto& lanes : sums.of)
      for (size_t at = 0; at < kTileSide; at += hn::MaxLanes(d))
        hn::StoreU(hn::Zero(d), d, lanes + at);
  };
  clear(job.sums);
  if (!job.request.motion->chip) return;
  clear(job.chip);
  for (CellSet& cells : job.chip_cells) cells.clear();
}

// Adds all lanes, in fixed pairs. So the order does not depend on the vector's width.
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

template <unsigned kSummed>
HWY_INLINE void RunWeighted(TileJob& job) {
  if (job.rays.axis == Axis::z)
    RunSummed<kSummed | kNodes>(job);
  else
    RunSummed<kSummed>(job);
}

void RunVectors(TileJob& job) {
  if (job.request.operation == Operation::paint) return PaintTile(job);
  const bool growing = is_growing(job.request.operation);
  // A tile is made writable only if there is something to write.
  if (job.request.motion->along) {
    if (growing && !MarkAdds(job)) return;
    job.ends = {};
  } else {
    if (!(growing ? MarkAdds(job) : MarkEndsInMaterial(job))) return;
    if (job.ends.rows) request_normals(job);
  }
  if (job.request.motion->chip && !scalar_sums(job)) ChipPass(job).Run(growing);
  if (job.request.motion->along && !scalar_sums(job)) {
    if (has_grain(job, job.sums_material))
      RunSummed<kLengths | kWeighted>(job);
    else
      RunSummed<kLengths>(job);
  } else if (scalar_sums(job)) {
    AddScalarSums(job, growing);
    RunSummed<kNothing>(job);
  } else if (has_grain(job, job.sums_material)) {
    RunWeighted<kCorrections | kWeighted>(job);
  } else {
    RunWeighted<kCorrections>(job);
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

// Calls f(lo, hi) for the tool's intervals on the z ray through the node, until f returns true.
// Returns true then.
template <class F>
static bool any_tool_interval(TileJob& job, const Index3& node, F&& f) {
  const auto u = static_cast<int>(node[0]), v = static_cast<int>(node[1]);
  // The z field is edited only in these tiles.
  if (!job.request.z || node[2] < job.request.z->depth_begin() || u < job.request.z_begin[0] ||
      u >= job.request.z_end[0] || v < job.request.z_begin[1] || v >= job.request.z_end[1])
    return false;
  const RayTile rays{Axis::z, u - place_in_tile(u), v - place_in_tile(v)};
  const int slot = (v - rays.v0) * kTileSide + u - rays.u0;
  for (int layer = 0;; layer++) {
    if (!(job.ties_rays == rays) || job.ties_layer != layer) {
      job.ties.normals_ready = 0;
      job.ties.last = false;
      job.ties_any = job.request.solid->spans(rays, layer, job.ties);
      job.ties_rays = rays;
      job.ties_layer = layer;
    }
    if (!job.ties_any) return false;
    if (((job.ties.rows >> (v - rays.v0)) & 1) && job.ties.lo[slot] < job.ties.hi[slot] &&
        f(job.ties.lo[slot], job.ties.hi[slot]))
      return true;
    if (job.ties.last) return false;
  }
}

// True if the tool's intervals along z, made longer by kTie at both ends, hold the node.
static bool tool_holds(TileJob& job, const Index3& node) {
  const float depth = static_cast<float>(node[2]) + 0.5f;
  return any_tool_interval(
      job, node, [&](float lo, float hi) { return lo - kTie <= depth && depth - kTie <= hi; });
}

// FieldSnapshot::holds(node, the deposited material, kTie), as it will be after the deposit. The
// deposit fills gaps only, and joins the spans of its material that it touches.
static bool deposit_will_hold(TileJob& job, const Index3& node) {
  const float depth = static_cast<float>(node[2]) + 0.5f;
  const FieldSnapshot& z = *job.request.z;
  if (node[2] < z.depth_begin() || !z.has_ray(node[0], node[1])) return false;
  // The part of the new span around the node that is known so far.
  float lo = kFar, hi = -kFar;
  // The gap around `at`, and the span that holds it.
  struct Around {
    float below = -kFar, above = kFar;
    bool held = false, own = false;
    float in = 0, out = 0;
  };
  // If two spans touch at `at`, `up` selects the upper one, otherwise the lower one.
  const auto around = [&](float at, bool up) {
    Around result;
    z.for_spans(node[0], node[1], [&](const Span& span) {
      if (up ? span.in <= at && at < span.out : span.in < at && at <= span.out) {
        result.held = true;
        result.own = span.material == job.request.material;
        result.in = span.in;
        result.out = span.out;
      }
      if (up ? span.out <= at : span.out < at) result.below = std::max(result.below, span.out);
      if (up ? span.in > at : span.in >= at) result.above = std::min(result.above, span.in);
    });
    return result;
  };
  // Extends the span beyond `at`. Returns false if it ends there.
  const auto extend = [&](float at, bool up) {
    const Around there = around(at, up);
    if (there.held && !there.own) return false;
    float in = there.in, out = there.out;
    if (!there.held && !any_tool_interval(job, node, [&](float a, float b) {
          if (!(up ? a <= at && at < b : a < at && at <= b)) return false;
          in = std::max(a, there.below);
          out = std::min(b, there.above);
          return true;
        }))
      return false;
    if (!(in < out)) return false;
    lo = std::min(lo, in);
    hi = std::max(hi, out);
    return true;
  };
  if (!extend(depth, true)) return false;
  while (!(depth + kTie < hi))
    if (!extend(hi, true)) return false;
  while (!(lo + kTie <= depth))
    if (!extend(lo, false)) return false;
  return true;
}

// For a span with an end at `depth`, its upper one if `at_hi`: the material of the span that
// touches this end, or -1 if there is none.
static int material_beyond(const TileJob& job, int row, int lane, float depth, bool at_hi) {
  const int slot = row * kTileSide + lane;
  for (const Plane* p = &job.tile->first; p && !p->empty_at(slot); p = p->next)
    if ((at_hi ? p->in[slot] : p->out[slot]) == depth) return p->material[slot];
  return -1;
}

bool holds_node(TileJob& job, int row, int lane, int k, EndOf end, int material, float depth,
                bool at_hi) {
  const Axis axis = job.rays.axis;
  Index3 node;
  node[u_index(axis)] = job.rays.u0 + lane;
  node[v_index(axis)] = job.rays.v0 + row;
  node[depth_index(axis)] = k;
  const FieldSnapshot& z = *job.request.z;
  if (is_growing(job.request.operation)) {
    const int own = job.request.material;
    if (end == EndOf::tool) return deposit_will_hold(job, node);
    if (end == EndOf::met) return !z.holds(node, own, kTie);
    if (const int beyond = material_beyond(job, row, lane, depth, at_hi); beyond >= 0) {
      // Two spans touch here, and both ends stay. The result differs only if the deposit extends
      // one of the spans along z, so that its material then holds the node.
      if (at_hi) return false;
      const bool gained = (material == own || beyond == own) && !z.holds(node, own, kTie) &&
                          deposit_will_hold(job, node);
      return !gained;
    }
    // An end of the deposit's own material vanishes. At other material, the deposit gets a new end,
    // which decides. The other material's end cannot decide: near the node, neither material may
    // hold it with the margin kTie.
    return material == own ? z.holds(node, own, kTie) : !deposit_will_hold(job, node);
  }
  const bool before = z.holds(node, material, kTie) &&
                      !(job.request.earlier && removed_earlier(*job.request.earlier, node));
  return end == EndOf::material ? before : !before || tool_holds(job, node);
}

FieldDirection direction_in_field(const TileJob& job) {
  const Vec3& shift = job.request.motion->shift.units;
  const double length = std::sqrt(shift.squaredNorm());
  if (!(length > 0)) return {0, 0, 0};
  const Axis axis = job.rays.axis;
  return {static_cast<float>(shift[u_index(axis)] / length),
          static_cast<float>(shift[v_index(axis)] / length),
          static_cast<float>(shift[depth_index(axis)] / length)};
}

// Ratio of the resistance to the material's u, for a piece with the share `late` of late wood.
static double grain_resistance(const TileJob& job, uint8_t material, double across2, double late) {
  const Grain& grain = *job.request.motion->grain;
  return grain.by_direction(material, across2) * (1 + grain.ring(material) * (late - kMeanLate));
}

// Displacement of an element at r from the reference point [lattice units].
static Vec3 displacement(const Motion& motion, const Vec3& r) {
  return motion.turning ? Vec3(motion.shift.units + motion.turn.cross(r)) : motion.shift.units;
}

// Adds one element of a ray to the sums of its material. `length`: its length along the ray; r: its
// position relative to the reference point.
static void add_element(const TileJob& job, RemovedPart& part, uint8_t material, double volume,
                        double length, const Vec3& r, double late) {
  const Motion& motion = *job.request.motion;
  part.moment += volume * r;
  const Vec3 s = displacement(motion, r);
  if (motion.chip) {
    RemovedPart::ChipSums& chip = part.chip();
    const int depth = depth_index(job.rays.axis);
    for (int i = 0; i < 3; i++) {
      const double extent = i == depth ? length : 1;
      chip.second[static_cast<size_t>(i)] += volume * (r[i] * r[i] + extent * extent / 12);
    }
    chip.second[3] += volume * r[0] * r[1];
    chip.second[4] += volume * r[0] * r[2];
    chip.second[5] += volume * r[1] * r[2];
    const double size = std::sqrt(s.squaredNorm());
    if (motion.turning && size > 0) {
      chip.section += volume / size;
      chip.path_volume += volume * size;
    }
  }
  if (has_grain(job, material)) {
    volume *= grain_resistance(job, material,
                               motion.turning ? motion.grain->across2(s) : motion.across2, late);
    part.start_weighted_sums();
    part.weighted_volume += volume;
    part.weighted_moment += volume * r;
  }
  const double s2 = s.squaredNorm();
  if (!motion.turning || !(s2 > 0)) return;
  const Vec3 f = (volume / s2) * s;
  RemovedPart::TurnSums& turn = part.turn();
  turn.force += f;
  turn.moment += r.cross(f);
  turn.moment_axis += r.dot(motion.tool_axis) * motion.tool_axis.cross(f);
}

void add_overlap(TileJob& job, int row, int lane, const Overlap& overlap, uint8_t span_material,
                 int sign, double late) {
  const int ui = u_index(job.rays.axis), vi = v_index(job.rays.axis),
            ti = depth_index(job.rays.axis);
  // In a deposit, the overlap counts as the deposited material, because it is subtracted from that
  // volume.
  const uint8_t material =
      job.request.material == kMixedMaterial ? span_material : job.request.material;
  RemovedPart& part = job.removed->part(material);
  const LatticePoint& reference = job.request.motion->reference;
  Vec3 r;
  r[ui] = job.rays.u0 + lane + 0.5 - reference[ui];
  r[vi] = job.rays.v0 + row + 0.5 - reference[vi];
  if (const Vec3* const along = job.request.motion->along) {
    const double length = sign * (*along)[ti] * (double{overlap.hi} - double{overlap.lo});
    r[ti] = 0.5 * (double{overlap.hi} + double{overlap.lo}) - reference[ti];
    part.correction += length;
    add_element(job, part, material, length, double{overlap.hi} - double{overlap.lo}, r, late);
    return;
  }
  const auto holds = [&](int k, bool at_hi) {
    return holds_node(job, row, lane, k,
                      end_of(at_hi ? overlap.tool_hi : overlap.tool_lo, overlap.added),
                      span_material, at_hi ? overlap.hi : overlap.lo, at_hi);
  };
  const RayVolume piece(overlap.lo, overlap.hi, overlap.weight_lo, overlap.weight_hi, holds,
                        job.request.z != nullptr);
  const auto add = [&](double volume, double from, double to) {
    if (volume == 0) return;
    r[ti] = 0.5 * (from + to) - reference[ti];
    add_element(job, part, material, sign * volume, to - from, r, late);
  };
  if (job.rays.axis == Axis::z) {
    const auto k0 = static_cast<int64_t>(piece.first), k1 = static_cast<int64_t>(piece.last);
    const int64_t n = sign * (k1 - k0);
    part.points += n;
    part.node_sum[static_cast<size_t>(ui)] += n * (job.rays.u0 + lane);
    part.node_sum[static_cast<size_t>(vi)] += n * (job.rays.v0 + row);
    part.node_sum[static_cast<size_t>(ti)] += n * (k0 + k1 - 1) / 2;
    add(piece.nodes(), static_cast<double>(k0), static_cast<double>(k1));
  }
  part.correction += sign * piece.correction();
  add(piece.correction_lo, overlap.lo, piece.first);
  add(piece.correction_hi, piece.last, overlap.hi);
  if (!job.request.motion->chip) return;
  part.chip().length +=
      sign * job.request.motion->length_weights[ti] * (double{overlap.hi} - double{overlap.lo});
  if (is_growing(job.request.operation)) return;
  if (overlap.hi - overlap.lo > kMinMet) {
    part.chip().cells[static_cast<size_t>(ui)].add16(job.rays.u0, 1u << lane);
    part.chip().cells[static_cast<size_t>(vi)].add16(job.rays.v0, 1u << row);
  }
  const auto add_front = [&](bool at_out, float depth, uint32_t code) {
    // The code is that of the remaining material, which ends where the tool begins.
    const Vec3 normal = -decode_normal(code, job.rays.axis, at_out);
    r[ti] = double{depth} - reference[ti];
    const Vec3 s = displacement(*job.request.motion, r);
    const double size = std::sqrt(s.squaredNorm());
    if (!(size > 0)) return;
    const double area = std::abs(normal[ti]) * std::max(0.0, normal.dot(s) / size);
    part.chip().front += area;
    part.chip().front_normal += area * normal;
  };
  const int slot = row * kTileSide + lane;
  if (overlap.tool_lo) add_front(true, overlap.lo, job.spans.codes.lo[slot]);
  if (overlap.tool_hi) add_front(false, overlap.hi, job.spans.codes.hi[slot]);
}

// A deposit that was clipped at the lattice's border ends in a face perpendicular to the ray.
static void face_lattice(TileJob& job) {
  for (int slot = 0; slot < kTileRays; slot++) {
    if (!((job.spans.rows >> (slot / kTileSide)) & 1)) continue;
    if (job.spans.lo[slot] == job.request.depth_begin) job.spans.codes.lo[slot] = 0;
    if (job.spans.hi[slot] == job.request.depth_end) job.spans.codes.hi[slot] = 0;
  }
}

// Adds the chip sums to `part`. `volume`, `moment`: the volume of these sums, and its first moment.
static void flush_chip(const TileJob& job, RemovedPart& part, double volume, const Vec3& moment) {
  const Axis axis = job.rays.axis;
  const int u = u_index(axis), v = v_index(axis), t = depth_index(axis);
  double sum[ChipLanes::kCount];
  for (size_t i = 0; i < ChipLanes::kCount; i++) {
    sum[i] = 0;
    for (const double lane : job.chip.of[i]) sum[i] += lane;
  }
  const Vec3* const along = job.request.motion->along;
  const double share = along ? (*along)[t] : 1;
  // Second moments about the point (u_ref, v_ref, t_ref).
  Mat3 second;
  second(u, u) = share * sum[ChipLanes::uu] + volume / 12;
  second(v, v) = share * sum[ChipLanes::vv] + volume / 12;
  second(t, t) = share * 0.25 * sum[ChipLanes::t2t2];
  second(u, v) = second(v, u) = share * sum[ChipLanes::uv];
  second(u, t) = second(t, u) = share * 0.5 * sum[ChipLanes::ut2];
  second(v, t) = second(t, v) = share * 0.5 * sum[ChipLanes::vt2];
  // Converts them to moments about Motion::reference. The point is `off` from it.
  Vec3 off;
  off[u] = double{job.request.u_ref} - job.request.motion->reference[u];
  off[v] = double{job.request.v_ref} - job.request.motion->reference[v];
  off[t] = double{job.request.t_ref} - job.request.motion->reference[t];
  const Vec3 first = moment - volume * off;
  second += first * off.transpose() + off * first.transpose() + volume * off * off.transpose();
  RemovedPart::ChipSums& chip = part.chip();
  for (int i = 0; i < 3; i++) chip.second[static_cast<size_t>(i)] += second(i, i);
  chip.second[3] += second(0, 1);
  chip.second[4] += second(0, 2);
  chip.second[5] += second(1, 2);
  for (size_t i = 0; i < 3; i++) chip.cells[i].add(job.chip_cells[i]);
  if (along) return;
  chip.length += job.request.motion->length_weights[t] * sum[ChipLanes::length];
  chip.front += sum[ChipLanes::front];
  chip.front_normal[u] += sum[ChipLanes::front_u];
  chip.front_normal[v] += sum[ChipLanes::front_v];
  chip.front_normal[t] += sum[ChipLanes::front_t];
}

void flush_sums(TileJob& job) {
  if (job.sums.material == kMixedMaterial) return;
  const auto u = u_index(job.rays.axis), v = v_index(job.rays.axis), t = depth_index(job.rays.axis);
  RemovedPart& part = job.removed->part(job.sums.material);
  using S = LaneSums;
  LaneTotals sum;
  HWY_DYNAMIC_DISPATCH(ReduceSums)(job.sums, sum);
  const LatticePoint& ref = job.request.motion->reference;
  // Adds the moment of the four sums that start at `of`. `from`: offset of their depth, in addition
  // to t_ref.
  const auto add_moment = [&](Vec3& moment, size_t of, double from, double times) {
    const double all = sum.of[of];
    moment[u] += times * (sum.by_lane[of] + sum.of[of + 1] + all * (0.5 - ref[u]));
    moment[v] += times * (sum.of[of + 2] + all * (0.5 - ref[v]));
    moment[t] += times * (0.5 * sum.of[of + 3] +
                          all * (static_cast<double>(job.request.t_ref) + from - ref[t]));
  };
  const Vec3* const along = job.request.motion->along;
  const double share = along ? (*along)[t] : 1;
  const double volume_before = part.volume();
  const Vec3 moment_before = part.moment;
  part.correction += share * sum.of[S::correction];
  add_moment(part.moment, S::correction, 0, share);
  if (has_grain(job, job.sums.material)) {
    const Motion& motion = *job.request.motion;
    const double times = share * motion.grain->by_direction(job.sums.material, motion.across2);
    part.start_weighted_sums();
    part.weighted_volume += times * sum.of[S::weighted];
    add_moment(part.weighted_moment, S::weighted, 0, times);
  }
  if (job.rays.axis == Axis::z && !along) {
    const double n = sum.of[S::nodes];
    part.points += static_cast<int64_t>(n);
    part.node_sum[static_cast<size_t>(u)] +=
        static_cast<int64_t>(sum.by_lane[S::nodes] + sum.of[S::nodes_u0]);
    part.node_sum[static_cast<size_t>(v)] += static_cast<int64_t>(sum.of[S::nodes_v]);
    part.node_sum[static_cast<size_t>(t)] += static_cast<int64_t>(
        0.5 * sum.of[S::nodes_t2] + n * static_cast<double>(job.request.t_ref));
    add_moment(part.moment, S::nodes, 0.5, 1);
  }
  if (job.request.motion->chip)
    flush_chip(job, part, part.volume() - volume_before, part.moment - moment_before);
}

// Sets the codes of these rows to 0, which is perpendicular to the ray. The solid may set no normal
// at an end that was clipped to the lattice.
static void clear_codes(SpanLayer& layer, unsigned rows) {
  for (unsigned left = rows; left; left &= left - 1) {
    const int slot = __builtin_ctz(left) * kTileSide;
    std::fill_n(layer.codes.lo + slot, kTileSide, 0u);
    std::fill_n(layer.codes.hi + slot, kTileSide, 0u);
  }
}

void request_normals(TileJob& job) {
  const bool growing = is_growing(job.request.operation);
  const unsigned missing = job.ends.rows & ~job.spans.normals_ready;
  if (missing) {
    if (growing) clear_codes(job.spans, missing);
    job.request.solid->normals(job.rays, job.layer, job.ends, job.spans);
  }
  if (growing) face_lattice(job);
  job.ends = {};
}

// Edits the rays that the vectors cannot handle.
static void edit_scalar_rays(TileJob& job, Tile& tile, bool growing) {
  for (int row = 0; row < kTileSide; row++)
    for (unsigned bits = job.scalar.rows[row]; bits; bits &= bits - 1) {
      const int lane = __builtin_ctz(bits), slot = row * kTileSide + lane;
      const float a = job.spans.lo[slot], b = job.spans.hi[slot];
      // An end that was there before is not the tool's, as in the vector path.
      unsigned had_a = 0, had_b = 0;
      for (const Plane* p = &tile.first; p && !p->empty_at(slot); p = p->next) {
        had_a |= (growing ? p->in : p->out)[slot] == a;
        had_b |= (growing ? p->out : p->in)[slot] == b;
      }
      if (growing)
        deposit_ray(*job.request.field, tile, slot, a, b, job.request.material);
      else
        cut_ray(*job.request.field, tile, slot, a, b);
      // The ends that the tool made are those at exactly a and b.
      for (const Plane* p = &tile.first; p && !p->empty_at(slot); p = p->next) {
        const unsigned at_a = (growing ? p->in : p->out)[slot] == a,
                       at_b = (growing ? p->out : p->in)[slot] == b;
        job.ends.mark(static_cast<size_t>(row), (at_a & ~had_a) << lane, (at_b & ~had_b) << lane);
      }
    }
  for (Plane* p = &tile.first; p; p = p->next) p->tight = false;
  job.shrank |= growing;  // here cuts only split spans, but deposits may join them
}

void take_sums(TileJob& job) {
  flush_sums(job);
  HWY_DYNAMIC_DISPATCH(ClearSums)(job);
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
  const bool growing = is_growing(operation);
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
