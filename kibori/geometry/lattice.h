// SPDX-License-Identifier: MIT
// Where a model's rays are. Points are millimetres in the world, or lattice units, which are pitches from the
// lattice's lower corner; the Lattice converts them.
#pragma once

#include <kibori/geometry/vec.h>

namespace kibori {

// Nodes stand at origin + (i + 1/2, j + 1/2, k + 1/2) * pitch, with i < nodes.x() and so on.
struct Lattice {
  Index3 nodes = Index3::Zero();
  Vec3 origin_mm = Vec3::Zero();  // lower corner of the lattice's box
  double pitch_mm = 1;            // between two rays

  Vec3 to_lattice(const Vec3& point_mm) const { return (point_mm - origin_mm) / pitch_mm; }
  Vec3 to_mm(const Vec3& point) const { return origin_mm + pitch_mm * point; }
  int nodes_along(int index) const { return nodes[index]; }
};

}  // namespace kibori
