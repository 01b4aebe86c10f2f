// SPDX-License-Identifier: MIT
// A tile: 16 x 16 rays of one dexel field, stored as planes.
//
//   plane 0   first span of every ray    in[256] out[256] normals material
//   plane 1   second span of every ray   (exists only if some ray has two)
//   ...
//
// Ray (i, j) of a tile has slot j * 16 + i. The index i runs along u. So the 16 rays of a row (the
// rays with the same j) are contiguous, as vector instructions need. A slot without a span has
// in = +kFar and out = -kFar. A ray has its spans in planes 0, 1, ... without gaps. The spans are
// sorted and disjoint, but may touch where the material changes. Depths are float32 numbers, in
// lattice units from the lattice's origin. Spans are half-open: [in, out).
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include <kibori/base/tolerances.h>
#include <kibori/geometry/color.h>

namespace kibori {

inline constexpr int kTileSide = 16;
inline constexpr int kTileRays = kTileSide * kTileSide;
// For the index of a ray along u or v: the index of its tile (may be negative), and the ray's index
// within that tile (0 to 15).
constexpr int tile_of_node(int node) { return node >> 4; }
constexpr int place_in_tile(int node) { return node & 15; }
static_assert(tile_of_node(kTileSide) == 1 && tile_of_node(-1) == -1 && place_in_tile(-1) == 15);
constexpr int slot_of_ray(int u, int v) { return place_in_tile(v) * kTileSide + place_in_tile(u); }
// Value of Tile::material if the tile's spans have several materials.
inline constexpr uint8_t kMixedMaterial = 255;

struct PaintPlane {
  alignas(64) Color in[kTileRays];
  alignas(64) Color out[kTileRays];
};

struct Plane {
  alignas(64) float in[kTileRays];
  alignas(64) float out[kTileRays];
  // Codes of normal_code.h. Normals point out of the material.
  alignas(64) uint32_t normal_in[kTileRays];
  alignas(64) uint32_t normal_out[kTileRays];
  alignas(64) uint8_t material[kTileRays];
  float near, far;  // bounds of all spans; an edit that is outside of them skips the plane
  bool tight;       // true if the bounds are exact; an edit sets it to false
  Plane* next;
  PaintPlane* paint;  // null if nothing in this plane was ever painted

  // True if the bounds overlap the depths from min to max, so that a span may do so.
  bool reaches(double min, double max) const { return near < max && far > min; }
  // Extends the bounds by a span.
  void include(float begin, float end) {
    near = std::min(near, begin);
    far = std::max(far, end);
  }
  void clear() {
    std::fill_n(in, kTileRays, kFar);
    std::fill_n(out, kTileRays, -kFar);
    std::fill_n(normal_in, kTileRays, 0u);
    std::fill_n(normal_out, kTileRays, 0u);
    std::fill_n(material, kTileRays, uint8_t{0});
    near = kFar;
    far = -kFar;
    tight = true;
    next = nullptr;
    paint = nullptr;
  }
  bool empty_at(int slot) const { return !(in[slot] < out[slot]); }
};

struct Tile {
  Plane first;
  std::atomic<uint32_t> refs;
  mutable std::atomic<uint64_t> hash;  // of the content; 0: not computed yet
  uint8_t material;                    // the material of all spans, or kMixedMaterial
  bool empty;                          // true if no ray has a span

  bool reaches(double min, double max) const {
    for (const Plane* p = &first; p; p = p->next)
      if (p->reaches(min, max)) return true;
    return false;
  }
  float near() const {
    float nearest = first.near;
    for (const Plane* p = first.next; p; p = p->next) nearest = std::min(nearest, p->near);
    return nearest;
  }
  float far() const {
    float farthest = first.far;
    for (const Plane* p = first.next; p; p = p->next) farthest = std::max(farthest, p->far);
    return farthest;
  }
};

}  // namespace kibori
