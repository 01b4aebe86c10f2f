// SPDX-License-Identifier: MIT
// A model as a solid: its spans are the intervals. Therefore, the edits of edit/edit.h also join,
// subtract and intersect bodies on one lattice. Ends that both bodies share are the same floats.
#pragma once

#include <optional>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/solid/solid.h>

namespace kibori {

class DexelSolid final : public Solid {
 public:
  // `bounds` [lattice units]: a box that holds all of the model's material. The edited model must
  // have the same lattice. `material`: use only the spans of this material. Then the layers have
  // gaps, so the solid must not be used in a Complement.
  DexelSolid(const Snapshot& model, const LatticeBox& bounds,
             std::optional<uint8_t> material = std::nullopt)
      : model_(model), bounds_(bounds), material_(material) {}

  LatticeBox bounds() const override { return bounds_; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  // Null if no ray of the tile has more than `layer` spans.
  const Plane* plane(const RayTile& rays, int layer) const;

  Snapshot model_;
  LatticeBox bounds_;
  std::optional<uint8_t> material_;
};

}  // namespace kibori
