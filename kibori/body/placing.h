// SPDX-License-Identifier: MIT
// Moves, turns or mirrors a model relative to its lattice. The surface of the model is extracted,
// transformed and scan-converted. Sharp edges stay sharp. Faces keep their positions to a few
// hundredths of a cell.
#pragma once

#include <memory>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// The map x -> linear x + shift [mm]. `linear` is a rotation, or a rotation and a mirror image.
struct Affine {
  Mat3 linear = Mat3::Identity();
  Vec3 shift = Vec3::Zero();
};

// Result of place_model.
struct Placed {
  std::unique_ptr<TriDexel> model;  // shares memory with the original model (TriDexel)
  bool clipped = false;             // true: a part was beyond the lattice, and is lost
};

// Returns the transformed model. Its materials and its paint may be displaced by up to a cell.
// Material that contains no node is lost. Errors: the result is larger than a lattice can be; an
// error of scan_convert.
Result<Placed> place_model(const Snapshot& model, const Affine& to, int threads = 1);

}  // namespace kibori
