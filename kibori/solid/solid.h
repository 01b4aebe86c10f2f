// SPDX-License-Identifier: MIT
// The one idea: a solid is whatever can say where a ray enters and leaves it.
//
// A solid answers for a whole tile of 16 x 16 rays at a time, in layers: layer 0 holds the first interval of
// every ray, layer 1 the second, and so on (convex solids have one). All coordinates are lattice units in the
// frame of the field that asks: ray (i, j) of the tile stands at u = u0 + i + 1/2, v = v0 + j + 1/2.
#pragma once

#include <cstdint>

#include <kibori/dexel/tile.h>
#include <kibori/geometry/axis.h>
#include <kibori/geometry/vec.h>

namespace kibori {

struct RayTile {
  Axis axis;
  int u0, v0;  // indices of the tile's first ray
};

// One interval [lo, hi) per ray; only rows whose bit is set in `rows` are filled, and in those a lane without
// an interval has lo = +kFar, hi = -kFar. Ends beyond the lattice (+-kFar included) are allowed.
struct SpanLayer {
  alignas(64) float lo[kTileRays];
  alignas(64) float hi[kTileRays];
  uint16_t rows;
};

// Which ends became ends of material: one bit a lane, one word a row.
struct EndMasks {
  uint16_t lo[kTileSide];
  uint16_t hi[kTileSide];
  bool flip;  // wanted: normals into the solid (a cut leaves material outside it)
};

// Codes of normal_code.h; direction: out of the solid, or into it if `flip`.
struct NormalCodes {
  alignas(64) uint32_t lo[kTileRays];
  alignas(64) uint32_t hi[kTileRays];
};

class Solid {
 public:
  virtual ~Solid() = default;

  // A box [lattice units, x y z] that holds the solid; infinite where the solid is.
  virtual Box bounds() const = 0;

  // Fills layer `layer`; false when no ray of the tile has so many intervals. Layers come in order along each
  // ray.
  virtual bool spans(const RayTile& rays, int layer, SpanLayer& out) const = 0;

  // Normals at the ends named in `ends`, of the layer that `spans` filled.
  virtual void normals(const RayTile& rays, int layer, const SpanLayer& spans, const EndMasks& ends,
                       NormalCodes& out) const = 0;
};

// All but `inside`: an intersection is a cut with the complement.
class Complement final : public Solid {
 public:
  explicit Complement(const Solid& inside) : inside_(inside) {}
  Box bounds() const override;
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const SpanLayer& spans, const EndMasks& ends,
               NormalCodes& out) const override;

 private:
  const Solid& inside_;
};

// `whole` less `part`; what a motion newly reaches is its sweep less the start pose. `part` must be convex.
class Difference final : public Solid {
 public:
  Difference(const Solid& whole, const Solid& part) : whole_(whole), part_(part) {}
  Box bounds() const override { return whole_.bounds(); }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const SpanLayer& spans, const EndMasks& ends,
               NormalCodes& out) const override;

 private:
  const Solid& whole_;
  const Solid& part_;
};

}  // namespace kibori
