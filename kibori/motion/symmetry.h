// SPDX-License-Identifier: MIT
// Planes of symmetry: what the tool does on one side, its images do on the others, tick by tick.
// Force is felt by the hand's own tool alone.
#pragma once

#include <array>

#include <kibori/base/result.h>
#include <kibori/motion/substeps.h>
#include <kibori/solid/tool.h>

namespace kibori {

struct Symmetry {
  std::array<bool, 3> planes{};   // normal to x, y, z
  Vec3 centre_mm = Vec3::Zero();  // a point of all of them

  bool any() const { return planes[0] || planes[1] || planes[2]; }
  bool operator==(const Symmetry& other) const {
    return planes == other.planes && centre_mm == other.centre_mm;
  }
};

// Ok, or a sentence: mesh tools can't be mirrored, all others can.
Status check_symmetry(const Symmetry& symmetry, const Tool& tool);

// The middle of the lattice [mm], where rays have rays for images.
Vec3 centre_of(const Lattice& lattice);

// A pose of the tool, and its motion, seen in the planes whose bits are set (1: normal to x, 2: y,
// 4: z), one after the other. The tool must be its own image in its local yz plane.
Pose image_of(const Pose& pose, const Vec3& centre_mm, unsigned planes);
ToolMotion image_of(const ToolMotion& motion, const Vec3& centre_mm, unsigned planes);

// Calls f(planes) for each image there is: every choice of the planes but none.
template <class F>
void for_images(const Symmetry& symmetry, F&& f) {
  unsigned all = 0;
  for (unsigned i = 0; i < 3; i++) all |= symmetry.planes[i] ? 1u << i : 0u;
  for (unsigned planes = 1; planes < 8; planes++)
    if ((planes & ~all) == 0) f(planes);
}

}  // namespace kibori
