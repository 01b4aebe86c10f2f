// SPDX-License-Identifier: MIT
#include <kibori/solid/dexel_solid.h>

#include <algorithm>

#include <kibori/dexel/normal_code.h>

namespace kibori {

const Plane* DexelSolid::plane(const RayTile& rays, int layer) const {
  const FieldSnapshot& field = model_.field(rays.axis);
  const int tu = tile_of_node(rays.u0), tv = tile_of_node(rays.v0);
  if (!field.has_tile(tu, tv)) return nullptr;
  const Tile& tile = field.tile(tu, tv);
  if (tile.empty) return nullptr;
  const Plane* plane = &tile.first;
  for (; plane && layer > 0; layer--) plane = plane->next;
  return plane;
}

bool DexelSolid::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  const Plane* const from = plane(rays, layer);
  if (!from) return false;
  std::copy_n(from->in, kTileRays, out.lo);
  std::copy_n(from->out, kTileRays, out.hi);
  if (material_)
    for (int slot = 0; slot < kTileRays; slot++)
      if (from->material[slot] != *material_) {
        out.lo[slot] = kFar;
        out.hi[slot] = -kFar;
      }
  out.rows = 0xffff;
  out.last = !from->next;
  return true;
}

void DexelSolid::normals(const RayTile& rays, int layer, const EndMasks& ends,
                         SpanLayer& of) const {
  const Plane& from = *plane(rays, layer);
  for (int row = 0; row < kTileSide; row++) {
    if (!((ends.rows >> row) & 1)) continue;
    for (int slot = row * kTileSide; slot < (row + 1) * kTileSide; slot++) {
      const uint32_t in = from.normal_in[slot], out = from.normal_out[slot];
      of.codes.lo[slot] = of.flip ? negate_normal(in) : in;
      of.codes.hi[slot] = of.flip ? negate_normal(out) : out;
    }
  }
}

}  // namespace kibori
