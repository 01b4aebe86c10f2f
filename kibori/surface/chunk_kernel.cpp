// SPDX-License-Identifier: MIT
#include <kibori/surface/chunk_kernel.h>

#include <kibori/base/vector_unit.h>
#include <kibori/surface/surface_vertex.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kibori/surface/chunk_kernel.cpp"
#include <hwy/foreach_target.h>
#include <kibori/base/lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kibori {
namespace HWY_NAMESPACE {

struct V3 {
  VF x, y, z;
};
HWY_INLINE VF Dot(const V3& a, const V3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE V3 Cross(const V3& a, const V3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

void FindPlaneEnds(const Plane& plane, float min, float max, PlaneEnds& ends) {
  const DF d;
  const VF low = F(min), high = F(max);
  for (size_t row = 0; row < kTileSide; row++) {
    unsigned begin = 0, end = 0;
    for (size_t g = 0; g < kGroups; g++) {
      const VF in = hn::Load(d, plane.in + row * kTileSide + g * kLanes);
      const VF out = hn::Load(d, plane.out + row * kTileSide + g * kLanes);
      const MF any = hn::Lt(in, out);
      begin |= Bits(hn::And(any, hn::And(hn::Gt(in, low), hn::Le(in, high)))) << (g * kLanes);
      end |= Bits(hn::And(any, hn::And(hn::Gt(out, low), hn::Le(out, high)))) << (g * kLanes);
    }
    ends.in[row] = static_cast<uint16_t>(begin);
    ends.out[row] = static_cast<uint16_t>(end);
  }
}

void FindPlaneNodes(const Plane& plane, float first, float count, PlaneNodes& nodes) {
  const DF d;
  // Node k is in [in, out) if in <= k + 1/2 < out. Depths are rounded to nodes before `first` is
  // subtracted. Otherwise the difference would round, and two chunks could disagree about a shared
  // node.
  const VF low = F(first), high = F(first + count);
  const VI from = hn::Set(DI(), static_cast<int32_t>(first));
  const auto node_after = [&](const float* depth) {
    const VF inside = hn::Min(hn::Max(hn::Load(d, depth), low), high);
    return hn::Sub(hn::ConvertTo(DI(), hn::Ceil(hn::Sub(inside, F(0.5f)))), from);
  };
  for (size_t i = 0; i < kTileRays; i += kLanes) {
    hn::Store(node_after(plane.in + i), DI(), nodes.from + i);
    hn::Store(node_after(plane.out + i), DI(), nodes.to + i);
  }
}

// Vector version of with_remainder.
HWY_INLINE VI WithRemainder(VI n, VI wanted) {
  const DI di;
  const VI ahead = hn::And(hn::Add(hn::Sub(wanted, n), hn::Set(di, 4)), hn::Set(di, 7));
  return hn::Sub(hn::Add(n, ahead), hn::Set(di, 4));
}

void PlaceSmoothSheets(const SheetSums& sums, size_t count, float quanta) {
  const DF d;
  const DI di;
  const VF scale = F(quanta), reach = F(kVertexReach), one = F(1.0f);
  const VI three_bits = hn::Set(di, 7);
  for (size_t i = 0; i < count; i += kLanes) {
    V3 p, n, products;
    VF number, known, unused;
    hn::LoadInterleaved4(d, sums.points[i].data(), p.x, p.y, p.z, number);
    hn::LoadInterleaved4(d, sums.normals[i].data(), n.x, n.y, n.z, known);
    hn::LoadInterleaved4(d, sums.products[i].data(), products.x, products.y, products.z, unused);
    const VF share = hn::Div(one, number);
    p.x = hn::Mul(p.x, share);
    p.y = hn::Mul(p.y, share);
    p.z = hn::Mul(p.z, share);
    const VF length = hn::Sqrt(Dot(n, n));
    // The normals' cosines to their mean add up to `length`. If the sum is nearly the number of
    // normals, no cosine is far below 1.
    MF smooth = hn::And(hn::Gt(known, hn::Zero(d)), hn::Gt(length, hn::Sub(known, F(1 - kFlat))));
    const VF along =
        hn::Div(hn::Sub(hn::Add(hn::Add(products.x, products.y), products.z), Dot(n, p)),
                hn::Mul(length, length));
    p.x = hn::Add(p.x, hn::Mul(along, n.x));
    p.y = hn::Add(p.y, hn::Mul(along, n.y));
    p.z = hn::Add(p.z, hn::Mul(along, n.z));
    smooth =
        hn::And(smooth, hn::Le(hn::Max(hn::Max(hn::Abs(p.x), hn::Abs(p.y)), hn::Abs(p.z)), reach));
    const VF to_unit = hn::Div(one, length);
    hn::StoreInterleaved4(hn::Mul(n.x, to_unit), hn::Mul(n.y, to_unit), hn::Mul(n.z, to_unit),
                          known, d, sums.normals[i].data());

    auto* const places = reinterpret_cast<int32_t*>(sums.centres + i);
    VI x, y, z, remainder;
    hn::LoadInterleaved4(di, places, x, y, z, remainder);
    const auto place = [&](VI centre, VF from_centre, VI wanted) {
      const VI n0 =
          hn::Add(centre, hn::NearestInt(hn::IfThenElseZero(smooth, hn::Mul(from_centre, scale))));
      return hn::IfThenElse(hn::RebindMask(di, smooth),
                            WithRemainder(n0, hn::And(wanted, three_bits)), centre);
    };
    x = place(x, p.x, remainder);
    y = place(y, p.y, hn::ShiftRight<3>(remainder));
    z = place(z, p.z, hn::ShiftRight<6>(remainder));
    hn::StoreInterleaved4(x, y, z, hn::IfThenElseZero(hn::RebindMask(di, smooth), hn::Set(di, 1)),
                          di, places);
  }
}

struct PlaceLanes {
  VI x, y, z, rank;
};
HWY_INLINE V3 Between(const PlaceLanes& from, const PlaceLanes& to) {
  const DF d;
  return {hn::ConvertTo(d, hn::Sub(to.x, from.x)), hn::ConvertTo(d, hn::Sub(to.y, from.y)),
          hn::ConvertTo(d, hn::Sub(to.z, from.z))};
}
// The two triangles next to one diagonal. The vectors to both sides and along the diagonal start at
// its first vertex.
struct Halves {
  VF bend;  // > 0: their normals are within 90 degrees
  MF clear;

  HWY_INLINE Halves(const V3& left, const V3& across, const V3& right) {
    const V3 m = Cross(left, across), n = Cross(across, right);
    bend = Dot(m, n);
    // The minimum angle is 1e-5. This is far above the rounding error of a degenerate triangle.
    const VF min = hn::Mul(F(1e-10f), Dot(across, across));
    clear = hn::And(hn::Gt(Dot(m, m), hn::Mul(min, Dot(left, left))),
                    hn::Gt(Dot(n, n), hn::Mul(min, Dot(right, right))));
  }
};

void ChooseQuadDiagonals(const Quad* quads, size_t count, const QuantizedPosition* places,
                         int32_t* chosen) {
  const DI di;
  const auto* const base = reinterpret_cast<const int32_t*>(places);
  const auto load = [&](VI vertex) {
    const VI at = hn::ShiftLeft<2>(vertex);
    return PlaceLanes{hn::GatherIndex(di, base, at), hn::GatherIndex(di, base + 1, at),
                      hn::GatherIndex(di, base + 2, at), hn::GatherIndex(di, base + 3, at)};
  };
  for (size_t i = 0; i < count; i += kLanes) {
    VI v0, v1, v2, v3;
    hn::LoadInterleaved4(di, reinterpret_cast<const int32_t*>(quads + i), v0, v1, v2, v3);
    const PlaceLanes a = load(v0), b = load(v1), c = load(v2), d = load(v3);
    const V3 ac = Between(a, c), bd = Between(b, d);
    const Halves first(Between(a, b), ac, Between(a, d)), second(Between(b, c), bd, Between(b, a));
    const MF smooth1 = hn::Gt(first.bend, hn::Zero(DF())),
             smooth2 = hn::Gt(second.bend, hn::Zero(DF()));
    const VI rank1 = hn::Add(a.rank, c.rank), rank2 = hn::Add(b.rank, d.rank);
    // The better diagonal, by these criteria in order: no fold, along a sharp edge, shorter.
    const auto by_rank = hn::RebindMask(DF(), hn::Gt(rank1, rank2));
    const auto same_rank = hn::RebindMask(DF(), hn::Eq(rank1, rank2));
    const MF shorter = hn::Le(Dot(ac, ac), Dot(bd, bd));
    const MF take_first =
        hn::Or(hn::AndNot(smooth2, smooth1),
               hn::AndNot(hn::Xor(smooth1, smooth2), hn::Or(by_rank, hn::And(same_rank, shorter))));
    const VI choice = hn::IfThenElse(hn::RebindMask(di, take_first), hn::Set(di, kFirstThird),
                                     hn::Set(di, kSecondFourth));
    hn::StoreU(hn::IfThenElse(hn::RebindMask(di, hn::And(first.clear, second.clear)), choice,
                              hn::Set(di, kUnclear)),
               di, chosen + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kibori
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kibori {

HWY_EXPORT(FindPlaneEnds);
HWY_EXPORT(FindPlaneNodes);
HWY_EXPORT(PlaceSmoothSheets);
HWY_EXPORT(ChooseQuadDiagonals);

ChunkKernel chunk_kernel() {
  choose_vector_unit();
  return {HWY_DYNAMIC_DISPATCH(FindPlaneEnds), HWY_DYNAMIC_DISPATCH(FindPlaneNodes),
          HWY_DYNAMIC_DISPATCH(PlaceSmoothSheets), HWY_DYNAMIC_DISPATCH(ChooseQuadDiagonals)};
}

}  // namespace kibori
#endif
