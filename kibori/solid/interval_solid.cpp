// SPDX-License-Identifier: MIT
#include <kibori/solid/interval_solid.h>

#include <atomic>

#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

// Solids that are asked about the same tile in turn, as the two of a Difference are.
constexpr size_t kRemembered = 4;

uint64_t next_id() {
  static std::atomic<uint64_t> id{1};
  return id++;
}

}  // namespace

IntervalSolid::IntervalSolid() : id_(next_id()) {}

const IntervalSolid::TileIntervals& IntervalSolid::intervals(const RayTile& rays) const {
  struct Remembered {
    uint64_t id = 0;
    RayTile rays{Axis::x, -1, -1};
    TileIntervals intervals;
  };
  struct Cache {
    std::array<Remembered, kRemembered> tiles;
    size_t oldest = 0;
  };
  thread_local Cache cache;
  for (const Remembered& one : cache.tiles)
    if (one.id == id_ && one.rays == rays) return one.intervals;
  Remembered& one = cache.tiles[cache.oldest];
  cache.oldest = (cache.oldest + 1) % kRemembered;
  one.id = id_;
  one.rays = rays;
  for (auto& list : one.intervals) list.clear();
  fill(rays, one.intervals);
  return one.intervals;
}

bool IntervalSolid::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  const TileIntervals& all = intervals(rays);
  const auto at = static_cast<size_t>(layer);
  out.last = true;
  out.rows = 0;
  for (size_t row = 0; row < kTileSide; row++) {
    bool any = false;
    for (size_t slot = row * kTileSide; slot < (row + 1) * kTileSide; slot++) {
      const bool there = at < all[slot].size();
      out.lo[slot] = there ? all[slot][at].lo : kFar;
      out.hi[slot] = there ? all[slot][at].hi : -kFar;
      any |= there;
      out.last &= at + 1 >= all[slot].size();
    }
    out.rows |= static_cast<uint16_t>(any << row);
  }
  return out.rows != 0;
}

void IntervalSolid::normals(const RayTile& rays, int layer, const EndMasks& ends,
                            SpanLayer& of) const {
  const TileIntervals& all = intervals(rays);
  for (size_t row = 0; row < kTileSide; row++)
    for (size_t lane = 0; lane < kTileSide; lane++) {
      const bool lo = (ends.lo[row] >> lane) & 1, hi = (ends.hi[row] >> lane) & 1;
      if (!lo && !hi) continue;
      const size_t slot = row * kTileSide + lane;
      const Interval& i = all[slot][static_cast<size_t>(layer)];
      if (lo) of.codes.lo[slot] = of.flip ? negate_normal(i.normal_lo) : i.normal_lo;
      if (hi) of.codes.hi[slot] = of.flip ? negate_normal(i.normal_hi) : i.normal_hi;
    }
}

}  // namespace kibori
