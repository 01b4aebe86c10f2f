// SPDX-License-Identifier: MIT
// A model as a solid: its spans are the intervals. So bodies on one lattice are joined, subtracted,
// and intersected by the same edits that tools make, and what both have is the same floats.
#pragma once

#include <optional>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/solid/solid.h>

namespace kibori {

class DexelSolid final : public Solid {
 public:
  // `bounds` [lattice units]: a box that holds all of its material. The model that is edited must
  // have the same lattice. `material`: only the spans of that one; such a solid has no Complement,
  // as its layers have gaps.
  DexelSolid(const Snapshot& model, const LatticeBox& bounds,
             std::optional<uint8_t> material = std::nullopt)
      : model_(model), bounds_(bounds), material_(material) {}

  LatticeBox bounds() const override { return bounds_; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  // Null where no ray of the tile has so many spans.
  const Plane* plane(const RayTile& rays, int layer) const;

  Snapshot model_;
  LatticeBox bounds_;
  std::optional<uint8_t> material_;
};

}  // namespace kibori
