// SPDX-License-Identifier: MIT
// Symmetry of a stroke: images of the tool repeat each of its ticks. An image is mirrored in
// planes, turned about an axis, or both. Only the hand's own tool causes a force.
#pragma once

#include <array>
#include <cstddef>

#include <kibori/base/result.h>
#include <kibori/geometry/axis.h>
#include <kibori/motion/substeps.h>
#include <kibori/solid/tool.h>

namespace kibori {

// Maximum of Symmetry::fold. It is small because each tick of the servo cuts all images.
inline constexpr int kMaxFold = 16;

struct Symmetry {
  std::array<bool, 3> planes{};   // normal to x, y, z
  Vec3 centre_mm = Vec3::Zero();  // a point on all planes and on the axis
  int fold = 1;                   // equal parts of a full turn about the axis; 1: no turn
  Axis axis = Axis::z;

  bool mirrors() const { return planes[0] || planes[1] || planes[2]; }
  bool any() const { return mirrors() || fold > 1; }
  bool operator==(const Symmetry&) const = default;
};

// Returns Ok, or an error if the centre is not finite or the fold is not 1 ... kMaxFold.
Status check_symmetry(const Symmetry& symmetry);

// Centre of the lattice's base [mm]. There, images of rays coincide with rays.
Vec3 centre_of(const Lattice& lattice);

// Map of an image: x maps to centre + turn (x - centre).
struct SymmetryImage {
  Mat3 turn = Mat3::Identity();
  bool mirrors = false;  // the determinant of `turn` is -1
};

// The images of a symmetry, without the tool itself. All are different. Allocates no memory.
class SymmetryImages {
 public:
  SymmetryImages() = default;
  explicit SymmetryImages(const Symmetry& symmetry);

  const SymmetryImage* begin() const { return images_.data(); }
  const SymmetryImage* end() const { return images_.data() + count_; }
  size_t size() const { return count_; }
  const Vec3& centre_mm() const { return centre_mm_; }

 private:
  std::array<SymmetryImage, 8 * kMaxFold> images_;
  size_t count_ = 0;
  Vec3 centre_mm_ = Vec3::Zero();
};

// Image of a position, of a pose of the tool, and of its motion. If the image mirrors, the frame of
// a mesh is left-handed. Every other tool is symmetric about its local yz plane, so its frame stays
// right-handed.
Vec3 image_of(const Vec3& place_mm, const Vec3& centre_mm, const SymmetryImage& image);
Pose image_of(const Pose& pose, const Tool& tool, const Vec3& centre_mm,
              const SymmetryImage& image);
ToolMotion image_of(const ToolMotion& motion, const Tool& tool, const Vec3& centre_mm,
                    const SymmetryImage& image);

}  // namespace kibori
