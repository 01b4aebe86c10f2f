// SPDX-License-Identifier: MIT
#include <kibori/solid/part_spans.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kibori/solid/part_spans.cpp"
#include <hwy/foreach_target.h>
#include <kibori/base/lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kibori {
namespace HWY_NAMESPACE {

// The interval of a part in one group of lanes. An empty lane begins at kFar and ends at -kFar.
struct PartEnds {
  VF lo, hi;
};
HWY_INLINE PartEnds EndsAt(const SpanLayer& part, size_t slot) {
  const DF d;
  const VF lo = hn::Load(d, part.lo + slot), hi = hn::Load(d, part.hi + slot);
  const MF live = hn::Lt(lo, hi);
  return {hn::IfThenElse(live, lo, F(kFar)), hn::IfThenElse(live, hi, F(-kFar))};
}
HWY_INLINE unsigned StoreSpans(VF lo, VF hi, size_t slot, SpanLayer& out) {
  const DF d;
  const MF live = hn::Lt(lo, hi);
  hn::Store(hn::IfThenElse(live, lo, F(kFar)), d, out.lo + slot);
  hn::Store(hn::IfThenElse(live, hi, F(-kFar)), d, out.hi + slot);
  return Bits(live);
}
// The smaller and the larger of two numbers. For +0 and -0 they return the first argument. (Min
// and Max differ there between vector units.)
HWY_INLINE VF Less(VF a, VF b) { return hn::IfThenElse(hn::Lt(b, a), b, a); }
HWY_INLINE VF More(VF a, VF b) { return hn::IfThenElse(hn::Lt(a, b), b, a); }

HWY_INLINE unsigned RowsOf(const SpanLayer* parts, size_t count) {
  unsigned rows = 0;
  for (size_t i = 0; i < count; i++) rows |= parts[i].rows;
  return rows;
}
// The parts that have an interval in one row.
struct RowParts {
  const SpanLayer* of[kMaxUnionParts];
  size_t count = 0;
};
HWY_INLINE RowParts PartsIn(unsigned row, const SpanLayer* parts, size_t count) {
  RowParts here;
  for (size_t i = 0; i < count; i++)
    if ((parts[i].rows >> row) & 1) here.of[here.count++] = &parts[i];
  return here;
}

void HullSpans(const SpanLayer* parts, size_t count, SpanLayer& out) {
  out.rows = static_cast<uint16_t>(RowsOf(parts, count));
  for (unsigned left = out.rows; left; left &= left - 1) {
    const auto row = static_cast<unsigned>(__builtin_ctz(left));
    const RowParts here = PartsIn(row, parts, count);
    for (size_t g = 0; g < kGroups; g++) {
      const size_t slot = row * kTileSide + g * kLanes;
      VF lo = F(kFar), hi = F(-kFar);
      for (size_t i = 0; i < here.count; i++) {
        const PartEnds part = EndsAt(*here.of[i], slot);
        lo = Less(lo, part.lo);
        hi = More(hi, part.hi);
      }
      StoreSpans(lo, hi, slot, out);
    }
  }
}

// The smallest begin of a part that is greater than `end`. kFar if there is none.
HWY_INLINE VF BeginBehind(VF end, const RowParts& here, size_t slot) {
  VF begin = F(kFar);
  for (size_t i = 0; i < here.count; i++) {
    const VF lo = EndsAt(*here.of[i], slot).lo;
    begin = hn::IfThenElse(hn::Gt(lo, end), Less(begin, lo), begin);
  }
  return begin;
}

// The end of the interval that begins at `begin`. It is the farthest end of the parts that begin
// within the interval. Each pass over all parts adds at least one more part.
HWY_INLINE VF EndFrom(VF begin, const RowParts& here, size_t slot) {
  VF end = begin;
  for (size_t pass = 0; pass < here.count; pass++)
    for (size_t i = 0; i < here.count; i++) {
      const PartEnds part = EndsAt(*here.of[i], slot);
      end = hn::IfThenElse(hn::Le(part.lo, end), More(end, part.hi), end);
    }
  return end;
}

void UnionSpans(const SpanLayer* parts, size_t count, int layer, SpanLayer& out) {
  out.rows = 0;
  out.last = true;
  for (unsigned left = RowsOf(parts, count); left; left &= left - 1) {
    const auto row = static_cast<unsigned>(__builtin_ctz(left));
    const RowParts here = PartsIn(row, parts, count);
    unsigned live = 0;
    for (size_t g = 0; g < kGroups; g++) {
      const size_t slot = row * kTileSide + g * kLanes;
      VF begin = BeginBehind(F(-2 * kFar), here, slot);
      VF end = EndFrom(begin, here, slot);
      for (int turn = 0; turn < layer; turn++) {
        begin = BeginBehind(end, here, slot);
        end = EndFrom(begin, here, slot);
      }
      live |= StoreSpans(begin, end, slot, out);
      const VF next = BeginBehind(end, here, slot);
      if (Bits(hn::Lt(next, F(kFar)))) out.last = false;
    }
    if (live) out.rows |= static_cast<uint16_t>(1u << row);
  }
}

void EndsMadeBy(const SpanLayer& part, const SpanLayer& of, const EndMasks& ends, EndMasks& made) {
  const DF d;
  for (unsigned left = part.rows & ends.rows; left; left &= left - 1) {
    const auto row = static_cast<unsigned>(__builtin_ctz(left));
    unsigned lo = 0, hi = 0;
    for (size_t g = 0; g < kGroups; g++) {
      const size_t slot = row * kTileSide + g * kLanes;
      const VF part_lo = hn::Load(d, part.lo + slot), part_hi = hn::Load(d, part.hi + slot);
      const unsigned live = Bits(hn::Lt(part_lo, part_hi));
      lo |= (live & Bits(hn::Eq(part_lo, hn::Load(d, of.lo + slot)))) << (g * kLanes);
      hi |= (live & Bits(hn::Eq(part_hi, hn::Load(d, of.hi + slot)))) << (g * kLanes);
    }
    made.mark(row, ends.lo[row] & lo, ends.hi[row] & hi);
  }
}

void TakeNormals(const SpanLayer& part, const EndMasks& ends, SpanLayer& of) {
  const DU du;
  const auto take = [&](const uint32_t* from, unsigned lanes, uint32_t* to) HWY_ATTR {
    const MF mask = FromBits(lanes & kGroupMask);
    hn::BlendedStore(hn::Load(du, from), hn::RebindMask(du, mask), du, to);
  };
  for (unsigned left = ends.rows; left; left &= left - 1) {
    const auto row = static_cast<unsigned>(__builtin_ctz(left));
    for (size_t g = 0; g < kGroups; g++) {
      const size_t slot = row * kTileSide + g * kLanes;
      take(part.codes.lo + slot, ends.lo[row] >> (g * kLanes), of.codes.lo + slot);
      take(part.codes.hi + slot, ends.hi[row] >> (g * kLanes), of.codes.hi + slot);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kibori
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kibori {
namespace {

HWY_EXPORT(HullSpans);
HWY_EXPORT(UnionSpans);
HWY_EXPORT(EndsMadeBy);
HWY_EXPORT(TakeNormals);

}  // namespace

void hull_spans(const SpanLayer* parts, size_t count, SpanLayer& out) {
  HWY_DYNAMIC_DISPATCH(HullSpans)(parts, count, out);
}

void union_spans(const SpanLayer* parts, size_t count, int layer, SpanLayer& out) {
  HWY_DYNAMIC_DISPATCH(UnionSpans)(parts, count, layer, out);
}

EndMasks ends_made_by(const SpanLayer& part, const SpanLayer& of, const EndMasks& ends) {
  EndMasks made = {};
  HWY_DYNAMIC_DISPATCH(EndsMadeBy)(part, of, ends, made);
  return made;
}

void take_normals(const SpanLayer& part, const EndMasks& ends, SpanLayer& of) {
  HWY_DYNAMIC_DISPATCH(TakeNormals)(part, ends, of);
}

}  // namespace kibori
#endif
