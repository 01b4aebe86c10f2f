// SPDX-License-Identifier: MIT
// A protected region that no tool may cut: a protected body, or a template within the stock. Edits
// subtract it from a tool's sweep. So its material stays the same, bit for bit. Where a cut reaches
// the region, the new surface has the region's normals.
#pragma once

#include <memory>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/solid/dexel_solid.h>

namespace kibori {

class NoGo {
 public:
  // `model` must have the lattice of the model that is edited.
  explicit NoGo(std::unique_ptr<TriDexel> model)
      : model_(std::move(model)), solid_(model_->snapshot(), model_->material_bounds()) {}

  // The region as a model. Forces treat it as a wall.
  const TriDexel& model() const { return *model_; }
  const DexelSolid& solid() const { return solid_; }
  const LatticeBox& bounds() const { return model_->material_bounds(); }
  // Mean outward normal of its surface within `radius` cells of a place, as a unit vector. It is
  // zero if there is no surface, or if the normals differ by too much.
  Vec3 normal_near(const LatticePoint& place, double radius) const;

 private:
  std::unique_ptr<TriDexel> model_;
  DexelSolid solid_;
};

// The solid `whole` without a protected region. Each end is exactly an end of one of the two.
class Except final : public Solid {
 public:
  Except(const Solid& whole, const NoGo& part);

  LatticeBox bounds() const override { return whole_.bounds(); }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

  // Allocates the memory that a tile needs on this thread, so that the servo tick does not
  // allocate.
  static void reserve();

 private:
  const Solid& whole_;
  const DexelSolid& part_;
  uint64_t id_;  // unique for each object
};

}  // namespace kibori
