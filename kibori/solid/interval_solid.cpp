// SPDX-License-Identifier: MIT
#include <kibori/solid/interval_solid.h>

#include <algorithm>
#include <atomic>

#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

// Number of tiles whose intervals a thread keeps. An edit may ask in turn for the tile that it
// edits and for a tile along z (tied ends, dexel/volume.h).
constexpr size_t kRemembered = 4;

uint64_t next_id() {
  static std::atomic<uint64_t> id{1};
  return id++;
}

}  // namespace

struct IntervalSolid::Remembered {
  uint64_t id = 0;
  RayTile rays{Axis::x, -1, -1};
  TileIntervals intervals;
  // The same intervals by layer: layer i holds the interval i of each ray. The first `layer_count`
  // layers are in use.
  struct Layer {
    std::array<float, kTileRays> lo, hi;
    uint16_t rows;
  };
  std::vector<Layer> layers;
  size_t layer_count = 0;

  void fill_layers() {
    layer_count = 0;
    for (const auto& list : intervals) layer_count = std::max(layer_count, list.size());
    if (layers.size() < layer_count) layers.resize(layer_count);
    for (size_t i = 0; i < layer_count; i++) {
      Layer& layer = layers[i];
      layer.rows = 0;
      for (size_t slot = 0; slot < kTileRays; slot++) {
        const auto& list = intervals[slot];
        const bool there = i < list.size();
        layer.lo[slot] = there ? list[i].lo : kFar;
        layer.hi[slot] = there ? list[i].hi : -kFar;
        layer.rows |= static_cast<uint16_t>(there << slot / kTileSide);
      }
    }
  }
};

IntervalSolid::IntervalSolid() : id_(next_id()) {}

const IntervalSolid::Remembered& IntervalSolid::remembered(const RayTile& rays) const {
  struct Cache {
    std::array<Remembered, kRemembered> tiles;
    size_t oldest = 0;
  };
  thread_local Cache cache;
  for (const Remembered& one : cache.tiles)
    if (one.id == id_ && one.rays == rays) return one;
  Remembered& one = cache.tiles[cache.oldest];
  cache.oldest = (cache.oldest + 1) % kRemembered;
  one.id = id_;
  one.rays = rays;
  for (auto& list : one.intervals) list.clear();
  fill(rays, one.intervals);
  one.fill_layers();
  return one;
}

bool IntervalSolid::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  const Remembered& tile = remembered(rays);
  const auto at = static_cast<size_t>(layer);
  out.last = at + 1 >= tile.layer_count;
  if (at >= tile.layer_count) return false;
  std::copy_n(tile.layers[at].lo.data(), kTileRays, out.lo);
  std::copy_n(tile.layers[at].hi.data(), kTileRays, out.hi);
  out.rows = tile.layers[at].rows;
  return true;
}

void IntervalSolid::normals(const RayTile& rays, int layer, const EndMasks& ends,
                            SpanLayer& of) const {
  const TileIntervals& all = remembered(rays).intervals;
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
