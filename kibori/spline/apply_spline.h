// SPDX-License-Identifier: MIT
// Applies a spline's shape to a model. The result depends only on the model, the shape and the
// operation. When the user drags a control point, the caller restores the model and applies the new
// shape. The functions allocate memory. Do not call them on the servo thread.
#pragma once

#include <cstdint>

#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/removed.h>
#include <kibori/spline/spline_shape.h>

namespace kibori {

// `deposit` adds the shape to the model, `cut` removes it, and `intersect` removes everything
// outside it.
enum class SplineOperation { deposit, cut, intersect };
constexpr Names<3> names_of(SplineOperation) { return {"deposit", "cut", "intersect"}; }

struct SplineOptions {
  int threads = 1;  // 1..3; the result does not depend on it
  // Maximum distance between the shape's mesh and the true shape [cells].
  double tolerance_cells = 0.02;
};

// Changes the model by the shape. A deposit has the material `material`. Returns the volume that
// was removed or, by a deposit, added: for each material, in lattice units. `Removed::clipped` is
// set if a part of the shape is beyond the lattice and is therefore missing. New ends of spans have
// the normals of the shape. Errors: those of make_spline_mesh, and a shape that reaches more than
// kMaxNodesPerAxis cells beyond the lattice. An error leaves the model unchanged.
Result<Removed> apply_spline(TriDexel& model, const SplineShape& shape, SplineOperation operation,
                             uint8_t material, const SplineOptions& options = {});
// The same for a mesh that exists already, for example one that was made for forces.
Result<Removed> apply_spline(TriDexel& model, const SplineMesh& shape, SplineOperation operation,
                             uint8_t material, const SplineOptions& options = {});

}  // namespace kibori
