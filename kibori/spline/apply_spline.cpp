// SPDX-License-Identifier: MIT
#include <kibori/spline/apply_spline.h>

#include <kibori/edit/edit.h>
#include <kibori/spline/shape_solid.h>

namespace kibori {

Result<Removed> apply_spline(TriDexel& model, const SplineShape& shape, SplineOperation operation,
                             uint8_t material, const SplineOptions& options) {
  const Result<SplineMesh> mesh =
      make_spline_mesh(shape, options.tolerance_cells * model.lattice().pitch_mm);
  if (!mesh) return Error{mesh.error()};
  return apply_spline(model, mesh.value(), operation, material, options);
}

Result<Removed> apply_spline(TriDexel& model, const SplineMesh& shape, SplineOperation operation,
                             uint8_t material, const SplineOptions& options) {
  const Result<ShapeSolid> made = ShapeSolid::make(shape, model.lattice(), options.threads);
  if (!made) return Error{made.error()};
  const ShapeSolid& solid = made.value();
  EditOptions edit;
  edit.threads = options.threads;
  Removed removed;
  switch (operation) {
    case SplineOperation::deposit:
      deposit(model, solid, material, edit, removed);
      break;
    case SplineOperation::cut:
      cut(model, solid, edit, removed);
      break;
    case SplineOperation::intersect:
      intersect(model, solid, edit, removed);
      break;
  }
  const Box shape_box = solid.bounds().units, room = model.lattice().whole().units;
  removed.clipped |= (shape_box.min.array() < room.min.array()).any() ||
                     (shape_box.max.array() > room.max.array()).any();
  return removed;
}

}  // namespace kibori
