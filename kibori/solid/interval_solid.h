// SPDX-License-Identifier: MIT
// A solid of any number of intervals a ray, found for a whole tile of rays at once and remembered
// while the same tile is asked about, layer by layer.
#pragma once

#include <array>
#include <vector>

#include <kibori/solid/solid.h>

namespace kibori {

class IntervalSolid : public Solid {
 public:
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const final;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const final;

 protected:
  struct Interval {
    float lo, hi;
    uint32_t normal_lo, normal_hi;  // out of the solid
  };
  using TileIntervals = std::array<std::vector<Interval>, kTileRays>;

  IntervalSolid();
  // Appends each ray's intervals, in order along it and apart from each other, to its empty list.
  virtual void fill(const RayTile& rays, TileIntervals& all) const = 0;

 private:
  struct Remembered;
  const Remembered& remembered(const RayTile& rays) const;
  uint64_t id_;
};

}  // namespace kibori
