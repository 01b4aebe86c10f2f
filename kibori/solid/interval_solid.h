// SPDX-License-Identifier: MIT
// A base class for solids with any number of intervals per ray. A derived class computes the
// intervals of all rays of a tile at once. Each thread keeps the intervals of its last few tiles,
// because the caller asks for the layers of a tile one by one.
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
    uint32_t normal_lo, normal_hi;  // codes of normals that point out of the solid
  };
  using TileIntervals = std::array<std::vector<Interval>, kTileRays>;

  IntervalSolid();
  // Appends the intervals of each ray to its list, which is empty before. The intervals must be
  // disjoint and in order along the ray.
  virtual void fill(const RayTile& rays, TileIntervals& all) const = 0;

 private:
  struct Remembered;
  const Remembered& remembered(const RayTile& rays) const;
  uint64_t id_;
};

}  // namespace kibori
