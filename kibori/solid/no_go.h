// SPDX-License-Identifier: MIT
// What nothing may cut: a body that is protected, or a template within the stock. A tool's sweep is
// cut without it, so what it holds stays to the bit, and walls that are laid bare have its normals.
#pragma once

#include <memory>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/solid/dexel_solid.h>

namespace kibori {

class NoGo {
 public:
  // `model` has the lattice of what is worked on.
  explicit NoGo(std::unique_ptr<TriDexel> model)
      : model_(std::move(model)), solid_(model_->snapshot(), model_->material_bounds()) {}

  // To be felt as a wall.
  const TriDexel& model() const { return *model_; }
  const DexelSolid& solid() const { return solid_; }
  const LatticeBox& bounds() const { return model_->material_bounds(); }
  // Out of it, as a mean over its surface within `radius` of a place [cells]; zero: there is none,
  // or it bends too much there. Its length is 1 otherwise.
  Vec3 normal_near(const LatticePoint& place, double radius) const;

 private:
  std::unique_ptr<TriDexel> model_;
  DexelSolid solid_;
};

// `whole` less a no-go body. Its ends are floats of one or the other.
class Except final : public Solid {
 public:
  Except(const Solid& whole, const NoGo& part);

  LatticeBox bounds() const override { return whole_.bounds(); }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

  // Takes the memory that a tile needs on this thread, so that a servo's tick need not.
  static void reserve();

 private:
  const Solid& whole_;
  const DexelSolid& part_;
  uint64_t id_;  // never given twice
};

}  // namespace kibori
