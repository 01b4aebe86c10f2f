// SPDX-License-Identifier: MIT
#include <kibori/motion/symmetry.h>

namespace kibori {
namespace {

// 1 and -1 on the diagonal.
Vec3 signs_of(unsigned planes) {
  return {planes & 1 ? -1.0 : 1.0, planes & 2 ? -1.0 : 1.0, planes & 4 ? -1.0 : 1.0};
}

}  // namespace

Status check_symmetry(const Symmetry& symmetry, const Tool& tool) {
  if (!symmetry.centre_mm.allFinite())
    return Error{"the planes of symmetry pass through no place at all"};
  if (symmetry.any() && std::holds_alternative<MeshTool>(tool))
    return Error{"a tool that is a mesh can't be mirrored; choose another, or no symmetry"};
  return Ok{};
}

Vec3 centre_of(const Lattice& lattice) { return lattice.to_mm(lattice.whole().centre()); }

Pose image_of(const Pose& pose, const Vec3& centre_mm, unsigned planes) {
  const Vec3 signs = signs_of(planes);
  Pose image;
  image.tip = centre_mm + signs.cwiseProduct(pose.tip - centre_mm);
  image.frame = signs.asDiagonal() * pose.frame;
  // An odd number of mirrors makes a left-handed frame; the tool's own symmetry turns it back.
  if (signs.prod() < 0) image.frame.col(0) = -image.frame.col(0);
  return image;
}

ToolMotion image_of(const ToolMotion& motion, const Vec3& centre_mm, unsigned planes) {
  const Vec3 signs = signs_of(planes);
  // Rotation vectors are axial.
  return {image_of(motion.start, centre_mm, planes), signs.cwiseProduct(motion.travel_mm),
          signs.prod() * signs.cwiseProduct(motion.turn_rad)};
}

}  // namespace kibori
