// SPDX-License-Identifier: MIT
// A spline's shape put into a model. What comes of it depends on the model as it is and on the
// shape only: a hand that drags control points restores the model as it was before, and applies the
// shape anew. It allocates: not for the servo thread.
#pragma once

#include <cstdint>

#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/removed.h>
#include <kibori/spline/spline_shape.h>

namespace kibori {

// The shape is added to the model, taken from it, or all beside it is taken away.
enum class SplineOperation { deposit, cut, intersect };
constexpr Names<3> names_of(SplineOperation) { return {"deposit", "cut", "intersect"}; }

struct SplineOptions {
  int threads = 1;  // 1..3; the result does not depend on it
  // How far the flattened shape may be from the true one [cells].
  double tolerance_cells = 0.02;
};

// Changes the model by the shape; `material` is what a deposit puts down. What was removed or (a
// deposit) added, by material, in lattice units; `clipped` where the shape reaches beyond the
// lattice, and so is not there. New ends of spans have the shape's own normals. Errors: those of
// make_spline_mesh, a shape farther than kMaxNodesPerAxis cells beyond the lattice; then the model
// stays as it is.
Result<Removed> apply_spline(TriDexel& model, const SplineShape& shape, SplineOperation operation,
                             uint8_t material, const SplineOptions& options = {});
// The same of a mesh that is made already, as one made for forces.
Result<Removed> apply_spline(TriDexel& model, const SplineMesh& shape, SplineOperation operation,
                             uint8_t material, const SplineOptions& options = {});

}  // namespace kibori
