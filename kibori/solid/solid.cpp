// SPDX-License-Identifier: MIT
#include <kibori/solid/solid.h>

#include <algorithm>
#include <limits>

namespace kibori {
namespace {

bool row_filled(const SpanLayer& layer, int row) { return (layer.rows >> row) & 1; }

}  // namespace

double max_over_rays(const RayTile& rays, const Box& bounds, const Vec3& slope, const Vec3& from) {
  Vec3 low, high;
  const int u = u_index(rays.axis), v = v_index(rays.axis), d = depth_index(rays.axis);
  low[u] = rays.u0;
  low[v] = rays.v0;
  low[d] = bounds.min[d];
  high[u] = rays.u0 + kTileSide;
  high[v] = rays.v0 + kTileSide;
  high[d] = bounds.max[d];
  double largest = 0;
  for (int i = 0; i < 3; i++)
    largest += std::max(slope[i] * (low[i] - from[i]), slope[i] * (high[i] - from[i]));
  return largest;
}

// ---- Complement: the gaps between the layers of `inside` ----

LatticeBox Complement::bounds() const {
  constexpr double inf = std::numeric_limits<double>::infinity();
  return {{Vec3::Constant(-inf), Vec3::Constant(inf)}};
}

bool Complement::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  // Gap k is between the end of interval k - 1 and the start of interval k.
  SpanLayer before, after;
  const bool has_before = layer > 0 && inside_.spans(rays, layer - 1, before);
  if (layer > 0 && !has_before) return false;
  const bool has_after = inside_.spans(rays, layer, after);
  out.rows = 0xffff;
  for (int row = 0; row < kTileSide; row++)
    for (int slot = row * kTileSide; slot < (row + 1) * kTileSide; slot++) {
      const bool in_before =
          layer > 0 && row_filled(before, row) && before.lo[slot] < before.hi[slot];
      const bool in_after = has_after && row_filled(after, row) && after.lo[slot] < after.hi[slot];
      const bool exists = layer == 0 || in_before;
      out.lo[slot] = !exists ? kFar : layer == 0 ? -kFar : before.hi[slot];
      out.hi[slot] = !exists ? -kFar : in_after ? after.lo[slot] : kFar;
    }
  return true;
}

void Complement::normals(const RayTile& rays, int layer, const EndMasks& ends,
                         SpanLayer& of) const {
  // The gap is between the end of interval (layer - 1) of `inside` and the begin of interval
  // (layer). Its outward normals point into `inside`.
  const auto turn = [&](int inner_layer, bool at_inner_hi, const uint16_t(&mask)[kTileSide],
                        uint32_t* to) {
    SpanLayer inner;
    inner.flip = !of.flip;
    if (inner_layer < 0 || !inside_.spans(rays, inner_layer, inner)) return;
    EndMasks want = {};
    for (int row = 0; row < kTileSide; row++)
      if (row_filled(inner, row))
        want.mark(static_cast<size_t>(row), at_inner_hi ? 0u : mask[row],
                  at_inner_hi ? mask[row] : 0u);
    inside_.normals(rays, inner_layer, want, inner);
    const uint32_t* from = at_inner_hi ? inner.codes.hi : inner.codes.lo;
    for (int row = 0; row < kTileSide; row++)
      for (int i = 0; i < kTileSide; i++)
        if (row_filled(inner, row) && ((mask[row] >> i) & 1))
          to[row * kTileSide + i] = from[row * kTileSide + i];
  };
  turn(layer - 1, true, ends.lo, of.codes.lo);
  turn(layer, false, ends.hi, of.codes.hi);
}

}  // namespace kibori
