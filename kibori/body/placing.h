// SPDX-License-Identifier: MIT
// A model put elsewhere on its own lattice: turned, moved, or mirrored. Its surface is moved and
// scan-converted; sharp edges stay sharp, and faces keep their places to a few hundredths of a
// cell.
#pragma once

#include <memory>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// x -> linear x + shift [mm]; `linear` is a turn, or a turn with a mirror.
struct Affine {
  Mat3 linear = Mat3::Identity();
  Vec3 shift = Vec3::Zero();
};

struct Placed {
  std::unique_ptr<TriDexel> model;  // beside the one that was placed (TriDexel)
  bool clipped = false;             // a part came to lie beyond the lattice, and is not there
};

// Materials and paint go with it, to the nearest cell. What holds no node is not there after that.
// Errors: it reaches farther than a lattice can.
Result<Placed> place_model(const Snapshot& model, const Affine& to, int threads = 1);

}  // namespace kibori
