// SPDX-License-Identifier: MIT
// The one idea: a solid is whatever can say where a ray enters and leaves it.
//
// A solid answers for a whole tile of 16 x 16 rays at a time, in layers: layer 0 holds the first
// interval of every ray, layer 1 the second, and so on (convex solids have one). All coordinates
// are lattice units in the frame of the field that asks: ray (i, j) of the tile stands at u = u0 +
// i + 1/2, v = v0 + j + 1/2.
#pragma once

#include <cstdint>

#include <kibori/dexel/tile.h>
#include <kibori/geometry/axis.h>
#include <kibori/geometry/lattice.h>

namespace kibori {

struct RayTile {
  Axis axis;
  int u0, v0;  // indices of the tile's first ray
  // What is asked about: of an interval beyond these depths a solid may say nothing.
  float near = -kFar, far = kFar;
  bool operator==(const RayTile&) const = default;
};

// Codes of normal_code.h at the two ends of every ray's interval.
struct NormalCodes {
  alignas(64) uint32_t lo[kTileRays];
  alignas(64) uint32_t hi[kTileRays];
};

// One interval [lo, hi) per ray; only rows whose bit is set in `rows` are filled, and in those a
// lane without an interval has lo >= hi. Ends beyond the lattice (+-kFar included) are allowed.
struct SpanLayer {
  alignas(64) float lo[kTileRays];
  alignas(64) float hi[kTileRays];
  uint16_t rows;
  // Set by who asks: normals into the solid (a cut leaves material outside it), else out of it.
  bool flip = false;
  // Set by `spans` where it knows that no ray of the tile has a further interval.
  bool last = false;
  // Rows whose normals `spans` has filled in already, as some solids can for nothing.
  uint16_t normals_ready = 0;
  NormalCodes codes;
};

// Which ends became ends of material: one bit a lane, one word a row.
struct EndMasks {
  uint16_t lo[kTileSide];
  uint16_t hi[kTileSide];
  uint16_t rows;  // those with any bit

  void mark(size_t row, unsigned lo_lanes, unsigned hi_lanes) {
    lo[row] |= static_cast<uint16_t>(lo_lanes);
    hi[row] |= static_cast<uint16_t>(hi_lanes);
    rows |= static_cast<uint16_t>(((lo_lanes | hi_lanes) != 0) << row);
  }
};

class Solid {
 public:
  virtual ~Solid() = default;

  // A box that holds the solid; infinite where the solid is.
  virtual LatticeBox bounds() const = 0;

  // Fills layer `layer`, whose `normals_ready` and `last` come in as 0; false when no ray of the
  // tile has so many intervals. Layers come in order along each ray.
  virtual bool spans(const RayTile& rays, int layer, SpanLayer& out) const = 0;

  // Fills in the normals at the ends marked in `ends` of a layer that `spans` filled; rows that are
  // `normals_ready` already may be left alone.
  virtual void normals(const RayTile& rays, int layer, const EndMasks& ends,
                       SpanLayer& of) const = 0;
};

// The most that slope'(x - from) comes to on those rays within the bounds [lattice units].
double most_on(const RayTile& rays, const Box& bounds, const Vec3& slope, const Vec3& from);

// All but `inside`: an intersection is a cut with the complement.
class Complement final : public Solid {
 public:
  explicit Complement(const Solid& inside) : inside_(inside) {}
  LatticeBox bounds() const override;
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  const Solid& inside_;
};

// `whole` less `part`; what a motion newly reaches is its sweep less the start pose. `part` must be
// convex. For contact only: ends made by `part` have no normals of their own.
class Difference final : public Solid {
 public:
  Difference(const Solid& whole, const Solid& part) : whole_(whole), part_(part) {}
  LatticeBox bounds() const override { return whole_.bounds(); }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  const Solid& whole_;
  const Solid& part_;
};

}  // namespace kibori
