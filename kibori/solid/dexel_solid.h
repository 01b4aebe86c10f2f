// SPDX-License-Identifier: MIT
// A model as a solid. The spans of the model are the intervals of the solid. Therefore, the edits
// of edit/edit.h can also join, subtract and intersect bodies on one lattice. The ends of the
// result are exact copies of the bodies' ends.
#pragma once

#include <optional>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/solid/solid.h>

namespace kibori {

class DexelSolid final : public Solid {
 public:
  // `bounds` [lattice units]: a box that contains all of the model's material. The lattice of the
  // edited model must have the same base. `material`, if given: the solid has only the spans of
  // this material. Its layers then have gaps, so the solid must not be used in a Complement.
  DexelSolid(const Snapshot& model, const LatticeBox& bounds,
             std::optional<uint8_t> material = std::nullopt)
      : model_(model), bounds_(bounds), material_(material) {}

  LatticeBox bounds() const override { return bounds_; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  // The plane of the tile with the spans of this layer. Null if no ray has more than `layer` spans.
  const Plane* plane(const RayTile& rays, int layer) const;

  Snapshot model_;
  LatticeBox bounds_;
  std::optional<uint8_t> material_;
};

}  // namespace kibori
