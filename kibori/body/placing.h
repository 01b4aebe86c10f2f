// SPDX-License-Identifier: MIT
// Converts a model to another place on its own lattice: turned, moved, or mirrored. The surface is
// transformed and scan-converted. Sharp edges stay sharp, and faces keep their positions to a few
// hundredths of a cell.
#pragma once

#include <memory>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// x -> linear x + shift [mm]. `linear` is a rotation, or a rotation with a mirror.
struct Affine {
  Mat3 linear = Mat3::Identity();
  Vec3 shift = Vec3::Zero();
};

// Result of place_model.
struct Placed {
  std::unique_ptr<TriDexel> model;  // shares memory with the original (TriDexel)
  bool clipped = false;             // a part is beyond the lattice, and is lost
};

// Materials and paint move with the model, with an error of up to a cell. Material that contains no
// node is lost. Errors: the result is larger than a lattice can be.
Result<Placed> place_model(const Snapshot& model, const Affine& to, int threads = 1);

}  // namespace kibori
