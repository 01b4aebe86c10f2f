// SPDX-License-Identifier: MIT
// A solid is anything that can compute where rays enter and leave it. `Solid` is the only
// interface.
//
// A solid handles a tile of 16 x 16 rays at a time, in layers. Layer 0 holds the first interval of
// every ray, layer 1 the second, and so on. A convex solid has only layer 0. All coordinates are
// lattice units. Ray (i, j) of a tile is at u = u0 + i + 1/2, v = v0 + j + 1/2 in the field of the
// tile's axis.
#pragma once

#include <cstdint>

#include <kibori/dexel/tile.h>
#include <kibori/geometry/axis.h>
#include <kibori/geometry/lattice.h>

namespace kibori {

struct RayTile {
  Axis axis;
  int u0, v0;  // indices of the tile's first ray
  // Range of depths that the caller needs. A solid may omit intervals outside this range.
  float near = -kFar, far = kFar;
  bool operator==(const RayTile&) const = default;
};

// Normal codes (dexel/normal_code.h) at both ends of each ray's interval.
struct NormalCodes {
  alignas(64) uint32_t lo[kTileRays];
  alignas(64) uint32_t hi[kTileRays];
};

// At most one interval [lo, hi) per ray. A row is filled only if its bit in `rows` is set. In a
// filled row, a lane without an interval has lo >= hi. Ends may be beyond the lattice, also +-kFar.
struct SpanLayer {
  alignas(64) float lo[kTileRays];
  alignas(64) float hi[kTileRays];
  uint16_t rows;
  // Set by the caller. True: normals must point into the solid, because a cut leaves the material
  // outside the solid. False: normals must point out of the solid.
  bool flip = false;
  // `spans` may set this if no ray of the tile has an interval in the next layer.
  bool last = false;
  // The rows whose normals `spans` has already stored in `codes`, one bit each.
  uint16_t normals_ready = 0;
  NormalCodes codes;
};

// A set of ends of a SpanLayer. `lo` and `hi` have one word per row, with one bit per lane.
struct EndMasks {
  uint16_t lo[kTileSide];
  uint16_t hi[kTileSide];
  uint16_t rows;  // the rows that have at least one bit

  void mark(size_t row, unsigned lo_lanes, unsigned hi_lanes) {
    lo[row] |= static_cast<uint16_t>(lo_lanes);
    hi[row] |= static_cast<uint16_t>(hi_lanes);
    rows |= static_cast<uint16_t>(((lo_lanes | hi_lanes) != 0) << row);
  }
};

class Solid {
 public:
  virtual ~Solid() = default;

  // Returns a box that contains the solid. It is infinite if the solid is infinite.
  virtual LatticeBox bounds() const = 0;

  // Fills layer `layer` of a tile. Returns false if no ray of the tile has this many intervals. The
  // caller sets `normals_ready` to 0 and `last` to false before. The intervals of a ray in layers
  // 0, 1, ... are in order along the ray.
  virtual bool spans(const RayTile& rays, int layer, SpanLayer& out) const = 0;

  // Stores the normals at the ends marked in `ends`, in a layer that `spans` has filled. May skip
  // the rows in `normals_ready`.
  virtual void normals(const RayTile& rays, int layer, const EndMasks& ends,
                       SpanLayer& of) const = 0;
};

// Returns the maximum of slope . (x - from) over the points x of a box. The box has the extent of
// the tile along u and v, and that of `bounds` along the depth [lattice units].
double max_over_rays(const RayTile& rays, const Box& bounds, const Vec3& slope, const Vec3& from);

// Everything outside the solid `inside`, which must outlive this object. To intersect a model with
// a solid, cut the model with the solid's complement.
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
