// SPDX-License-Identifier: MIT
// A tile: 16 x 16 rays of one dexel field, stored as planes.
//
//   plane 0   first span of every ray    in[256] out[256] normals material
//   plane 1   second span of every ray   (exists only if some ray has two)
//   ...
//
// Ray (i, j) of a tile is slot j * 16 + i. i runs along u, so a row of 16 rays is contiguous, as
// vector instructions need. A slot without a span has in = +kFar, out = -kFar. The spans of a ray
// fill the planes from 0 without gaps. They are sorted and disjoint; they may touch where the
// material changes. Depths are float32 lattice units from the lattice's origin. Spans are half-open
// [in, out).
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include <kibori/base/tolerances.h>
#include <kibori/geometry/color.h>

namespace kibori {

inline constexpr int kTileSide = 16;
inline constexpr int kTileRays = kTileSide * kTileSide;
// The tile that holds a ray, and the ray's place in it, along u or v. Indices may be negative.
constexpr int tile_of_node(int node) { return node >> 4; }
constexpr int place_in_tile(int node) { return node & 15; }
static_assert(tile_of_node(kTileSide) == 1 && tile_of_node(-1) == -1 && place_in_tile(-1) == 15);
constexpr int slot_of_ray(int u, int v) { return place_in_tile(v) * kTileSide + place_in_tile(u); }
// Tile::material of a tile whose spans have several materials.
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
  float near, far;  // bounds of all spans; an edit outside of them skips the plane
  bool tight;       // true if the bounds are exact; an edit sets it to false
  Plane* next;
  PaintPlane* paint;  // null if nothing in this plane was ever painted

  // True if a span may reach depths between min and max.
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
  mutable std::atomic<uint64_t> hash;  // of the content; 0: not computed
  uint8_t material;                    // of every span in the tile, or kMixedMaterial
  bool empty;                          // no span at all

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
