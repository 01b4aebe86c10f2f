// SPDX-License-Identifier: MIT
// A protected region that no tool may cut, for example a protected body, or a template within the
// stock. Edits subtract the region from the tool's sweep. Therefore, material in the region stays
// the same, bit for bit. Where a cut ends at the region, the new surface has the region's normals.
#pragma once

#include <memory>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/solid/dexel_solid.h>

namespace kibori {

class NoGo {
 public:
  // The lattices of `model` and of the edited model must have the same base.
  explicit NoGo(std::unique_ptr<TriDexel> model)
      : model_(std::move(model)), solid_(model_->snapshot(), model_->material_bounds()) {}

  // The region as a model. Forces treat the region as a wall.
  const TriDexel& model() const { return *model_; }
  const DexelSolid& solid() const { return solid_; }
  const LatticeBox& bounds() const { return model_->material_bounds(); }
  // Returns the mean outward normal of the region's surface within `radius` cells of a place, as a
  // unit vector. Returns zero if there is no surface, or if the normals differ too much.
  Vec3 normal_near(const LatticePoint& place, double radius) const;

 private:
  std::unique_ptr<TriDexel> model_;
  DexelSolid solid_;
};

// The solid `whole` without a protected region. Each end is exactly an end of `whole` or of the
// region. Both must outlive this object.
class Except final : public Solid {
 public:
  Except(const Solid& whole, const NoGo& part);

  LatticeBox bounds() const override { return whole_.bounds(); }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

  // Allocates this thread's memory for the intervals of a tile. Call it on the servo thread, so
  // that ticks do not allocate.
  static void reserve();

 private:
  const Solid& whole_;
  const DexelSolid& part_;
  uint64_t id_;  // unique for each object
};

}  // namespace kibori
