// SPDX-License-Identifier: MIT
// Applies a spline's shape to a model. The result depends only on the model, the shape and the
// operation. When the user drags a control point, the caller restores the model and applies the new
// shape. The functions allocate memory, so do not call them on the servo thread.
#pragma once

#include <cstdint>

#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/removed.h>
#include <kibori/spline/spline_shape.h>

namespace kibori {

// Adds the shape to the model, removes it, or removes everything outside it.
enum class SplineOperation { deposit, cut, intersect };
constexpr Names<3> names_of(SplineOperation) { return {"deposit", "cut", "intersect"}; }

struct SplineOptions {
  int threads = 1;  // 1..3; the result does not depend on it
  // Maximum distance between the flattened shape and the true one [cells].
  double tolerance_cells = 0.02;
};

// Changes the model by the shape. `material` is the material of a deposit. Returns the removed or
// (for a deposit) added volume, by material, in lattice units. `clipped` is set if a part of the
// shape is missing because it is beyond the lattice. New ends of spans have the normals of the
// shape.
// Errors: those of make_spline_mesh, and a shape farther than kMaxNodesPerAxis cells beyond the
// lattice. An error leaves the model unchanged.
Result<Removed> apply_spline(TriDexel& model, const SplineShape& shape, SplineOperation operation,
                             uint8_t material, const SplineOptions& options = {});
// The same for an existing mesh, for example one that was made for forces.
Result<Removed> apply_spline(TriDexel& model, const SplineMesh& shape, SplineOperation operation,
                             uint8_t material, const SplineOptions& options = {});

}  // namespace kibori
