// SPDX-License-Identifier: MIT
// A solid computes where rays enter and leave it. This is its only interface.
//
// A solid handles a whole tile of 16 x 16 rays at a time, in layers. Layer 0 holds the first
// interval of every ray, layer 1 the second, and so on (convex solids have one). All coordinates
// are lattice units in the frame of the calling field. Ray (i, j) of the tile is at u = u0 + i +
// 1/2, v = v0 + j + 1/2.
#pragma once

#include <cstdint>

#include <kibori/dexel/tile.h>
#include <kibori/geometry/axis.h>
#include <kibori/geometry/lattice.h>

namespace kibori {

struct RayTile {
  Axis axis;
  int u0, v0;  // indices of the tile's first ray
  // Range of depths of interest. A solid may omit intervals outside of it.
  float near = -kFar, far = kFar;
  bool operator==(const RayTile&) const = default;
};

// Codes of normal_code.h at the two ends of every ray's interval.
struct NormalCodes {
  alignas(64) uint32_t lo[kTileRays];
  alignas(64) uint32_t hi[kTileRays];
};

// One interval [lo, hi) per ray. Only rows whose bit is set in `rows` are filled. In those, a lane
// without an interval has lo >= hi. Ends beyond the lattice (+-kFar included) are allowed.
struct SpanLayer {
  alignas(64) float lo[kTileRays];
  alignas(64) float hi[kTileRays];
  uint16_t rows;
  // Set by the caller. True: normals point into the solid, because a cut leaves the material
  // outside of it. False: they point out of the solid.
  bool flip = false;
  // Set by `spans` if no ray of the tile has a further interval.
  bool last = false;
  // Rows whose normals `spans` has already filled in, because it had computed them anyway.
  uint16_t normals_ready = 0;
  NormalCodes codes;
};

// A set of ends of a SpanLayer: one bit per lane, one word per row.
struct EndMasks {
  uint16_t lo[kTileSide];
  uint16_t hi[kTileSide];
  uint16_t rows;  // rows with any bit

  void mark(size_t row, unsigned lo_lanes, unsigned hi_lanes) {
    lo[row] |= static_cast<uint16_t>(lo_lanes);
    hi[row] |= static_cast<uint16_t>(hi_lanes);
    rows |= static_cast<uint16_t>(((lo_lanes | hi_lanes) != 0) << row);
  }
};

class Solid {
 public:
  virtual ~Solid() = default;

  // A box that contains the solid; infinite where the solid is.
  virtual LatticeBox bounds() const = 0;

  // Fills layer `layer`. The caller sets `normals_ready` and `last` to 0. Returns false if no ray
  // of the tile has this many intervals. Layers are in order along each ray.
  virtual bool spans(const RayTile& rays, int layer, SpanLayer& out) const = 0;

  // Fills in the normals at the ends marked in `ends`, in a layer that `spans` filled. May skip
  // rows that are `normals_ready`.
  virtual void normals(const RayTile& rays, int layer, const EndMasks& ends,
                       SpanLayer& of) const = 0;
};

// Maximum of slope . (x - from) over the points x of a tile's rays at the depths of `bounds`
// [lattice units].
double max_over_rays(const RayTile& rays, const Box& bounds, const Vec3& slope, const Vec3& from);

// The complement of `inside`. An intersection is a cut with the complement.
class Complement final : public Solid {
 public:
  explicit Complement(const Solid& inside) : inside_(inside) {}
  LatticeBox bounds() const override;
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  const Solid& inside_;
};

}  // namespace kibori
