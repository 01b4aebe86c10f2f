// SPDX-License-Identifier: MIT
// Symmetry of a stroke: images of the tool repeat every tick of the stroke. An image is mirrored in
// planes, turned about an axis, or both. Only the tool itself causes a force on the hand.
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
  std::array<bool, 3> planes{};   // mirror planes normal to x, y, z
  Vec3 centre_mm = Vec3::Zero();  // a point on all planes and on the axis
  int fold = 1;                   // number of equal parts of a full turn about the axis; 1: no turn
  Axis axis = Axis::z;

  bool mirrors() const { return planes[0] || planes[1] || planes[2]; }
  bool any() const { return mirrors() || fold > 1; }
  bool operator==(const Symmetry&) const = default;
};

// Returns Ok if `symmetry` is valid. Errors: the centre is not finite; fold is not 1 ... kMaxFold.
Status check_symmetry(const Symmetry& symmetry);

// Returns the centre of the lattice's base [mm]. Around this centre, the images of rays coincide
// with rays.
Vec3 centre_of(const Lattice& lattice);

// The map of an image: a point x moves to centre + turn (x - centre).
struct SymmetryImage {
  Mat3 turn = Mat3::Identity();
  bool mirrors = false;  // true if the determinant of `turn` is -1
};

// The images of a symmetry, without the tool itself. No two images are equal. Does not allocate.
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

// Return the image of a position, of a pose, or of a motion of `tool`. If the image mirrors a mesh,
// the frame becomes left-handed. Every other tool is symmetric about its local yz plane, so its
// frame stays right-handed.
Vec3 image_of(const Vec3& place_mm, const Vec3& centre_mm, const SymmetryImage& image);
Pose image_of(const Pose& pose, const Tool& tool, const Vec3& centre_mm,
              const SymmetryImage& image);
ToolMotion image_of(const ToolMotion& motion, const Tool& tool, const Vec3& centre_mm,
                    const SymmetryImage& image);

}  // namespace kibori
