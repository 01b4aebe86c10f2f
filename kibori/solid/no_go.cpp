// SPDX-License-Identifier: MIT
#include <kibori/solid/no_go.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <vector>

#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

struct Interval {
  float lo, hi;
  uint32_t normal_lo, normal_hi;  // out of the solid
};
using TileIntervals = std::array<std::vector<Interval>, kTileRays>;

// The last tile that this thread asked for.
struct Cache {
  uint64_t id = 0;
  RayTile rays{Axis::x, -1, -1};
  TileIntervals whole, part, rest;
};
Cache& cache() {
  thread_local Cache own;
  return own;
}
constexpr size_t kReady = 16;  // intervals per ray

void collect(const Solid& solid, const RayTile& rays, TileIntervals& all) {
  for (auto& list : all) list.clear();
  SpanLayer layer;
  for (int i = 0;; i++) {
    layer.normals_ready = 0;
    layer.last = false;
    if (!solid.spans(rays, i, layer)) return;
    EndMasks ends = {};
    for (size_t row = 0; row < kTileSide; row++) {
      if (!((layer.rows >> row) & 1)) continue;
      unsigned lanes = 0;
      for (size_t lane = 0; lane < kTileSide; lane++) {
        const size_t slot = row * kTileSide + lane;
        if (layer.lo[slot] < layer.hi[slot]) lanes |= 1u << lane;
      }
      ends.mark(row, lanes, lanes);
    }
    solid.normals(rays, i, ends, layer);
    for (size_t row = 0; row < kTileSide; row++)
      for (size_t lane = 0; lane < kTileSide; lane++) {
        const size_t slot = row * kTileSide + lane;
        if ((ends.lo[row] >> lane) & 1)
          all[slot].push_back(
              {layer.lo[slot], layer.hi[slot], layer.codes.lo[slot], layer.codes.hi[slot]});
      }
    if (layer.last) return;
  }
}

void subtract(const std::vector<Interval>& whole, const std::vector<Interval>& part,
              std::vector<Interval>& rest) {
  rest.clear();
  for (Interval left : whole) {
    for (const Interval& p : part) {
      if (p.hi <= left.lo) continue;
      if (p.lo >= left.hi) break;
      // At an end of the removed part, the outward normal of the rest is the inward normal of the
      // part.
      if (p.lo > left.lo)
        rest.push_back({left.lo, p.lo, left.normal_lo, negate_normal(p.normal_lo)});
      left.lo = p.hi;
      left.normal_lo = negate_normal(p.normal_hi);
    }
    if (left.lo < left.hi) rest.push_back(left);
  }
}

const TileIntervals& rest_of(uint64_t id, const RayTile& rays, const Solid& whole,
                             const Solid& part) {
  Cache& at = cache();
  if (at.id == id && at.rays == rays) return at.rest;
  collect(whole, rays, at.whole);
  collect(part, rays, at.part);
  for (size_t slot = 0; slot < kTileRays; slot++)
    subtract(at.whole[slot], at.part[slot], at.rest[slot]);
  at.id = id;
  at.rays = rays;
  return at.rest;
}

}  // namespace

Vec3 NoGo::normal_near(const LatticePoint& place, double radius) const {
  // The normals must be within about 15 degrees of their mean: |sum| >= kAlike * (sum of weights).
  constexpr double kAlike = 0.97;
  Vec3 sum = Vec3::Zero();
  double all = 0;
  for (const Axis axis : kAxes) {
    const FieldSnapshot& field = model_->field(axis).view();
    const double u = place.units[u_index(axis)], v = place.units[v_index(axis)],
                 depth = place.units[depth_index(axis)];
    const auto add = [&](int i, int j, float end, uint32_t code, bool out) {
      const Vec3 off(i + 0.5 - u, j + 0.5 - v, end - depth);
      const double near = 1 - off.squaredNorm() / (radius * radius);
      if (!(near > 0)) return;
      // The number of rays that meet a face is proportional to this component of its normal. With
      // the factor, each field counts a face by the square of the component. The squares add up to
      // 1 over the three fields.
      const Vec3 normal = decode_normal(code, axis, out);
      const double weight = near * near * std::abs(normal[depth_index(axis)]);
      sum += weight * normal;
      all += weight;
    };
    const int u_end = std::min(field.u_end(), static_cast<int>(std::ceil(u + radius))),
              v_end = std::min(field.v_end(), static_cast<int>(std::ceil(v + radius)));
    for (int j = std::max(field.v_begin(), static_cast<int>(std::floor(v - radius))); j < v_end;
         j++)
      for (int i = std::max(field.u_begin(), static_cast<int>(std::floor(u - radius))); i < u_end;
           i++)
        field.for_spans(i, j, [&](const Span& span) {
          add(i, j, span.in, span.normal_in, false);
          add(i, j, span.out, span.normal_out, true);
        });
  }
  const double length = std::sqrt(sum.squaredNorm());
  return length > kAlike * all && length > 0 ? Vec3(sum / length) : Vec3(Vec3::Zero());
}

Except::Except(const Solid& whole, const NoGo& part) : whole_(whole), part_(part.solid()) {
  static std::atomic<uint64_t> next{1};
  id_ = next++;
}

bool Except::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  const TileIntervals& rest = rest_of(id_, rays, whole_, part_);
  bool any = false;
  out.last = true;
  out.rows = 0xffff;
  const auto i = static_cast<size_t>(layer);
  for (size_t slot = 0; slot < kTileRays; slot++) {
    const auto& list = rest[slot];
    const bool there = i < list.size();
    out.lo[slot] = there ? list[i].lo : kFar;
    out.hi[slot] = there ? list[i].hi : -kFar;
    any |= there;
    out.last &= i + 1 >= list.size();
  }
  return any;
}

void Except::normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const {
  const TileIntervals& rest = rest_of(id_, rays, whole_, part_);
  for (size_t row = 0; row < kTileSide; row++)
    for (size_t lane = 0; lane < kTileSide; lane++) {
      const bool lo = (ends.lo[row] >> lane) & 1, hi = (ends.hi[row] >> lane) & 1;
      if (!lo && !hi) continue;
      const size_t slot = row * kTileSide + lane;
      const Interval& i = rest[slot][static_cast<size_t>(layer)];
      if (lo) of.codes.lo[slot] = of.flip ? negate_normal(i.normal_lo) : i.normal_lo;
      if (hi) of.codes.hi[slot] = of.flip ? negate_normal(i.normal_hi) : i.normal_hi;
    }
}

void Except::reserve() {
  Cache& at = cache();
  for (TileIntervals* const all : {&at.whole, &at.part, &at.rest})
    for (auto& list : *all) list.reserve(kReady);
}

}  // namespace kibori
