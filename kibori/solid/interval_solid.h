// SPDX-License-Identifier: MIT
// A solid with any number of intervals per ray. It computes them for a whole tile of rays at once.
// It keeps them while the caller asks for the layers of that tile.
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
  // Appends each ray's intervals to its empty list, in order along the ray and disjoint.
  virtual void fill(const RayTile& rays, TileIntervals& all) const = 0;

 private:
  struct Remembered;
  const Remembered& remembered(const RayTile& rays) const;
  uint64_t id_;
};

}  // namespace kibori
