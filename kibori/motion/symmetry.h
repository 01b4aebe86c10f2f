// SPDX-License-Identifier: MIT
// Symmetry of a stroke: what the tool does on one side, its images do on the others, tick by tick.
// SymmetryImages are mirrored in planes, turned about an axis, or both. Force is felt by the hand's
// own tool alone.
#pragma once

#include <array>
#include <cstddef>

#include <kibori/base/result.h>
#include <kibori/geometry/axis.h>
#include <kibori/motion/substeps.h>
#include <kibori/solid/tool.h>

namespace kibori {

// The most images about an axis: a tick of the servo cuts them all.
inline constexpr int kMaxFold = 16;

struct Symmetry {
  std::array<bool, 3> planes{};   // normal to x, y, z
  Vec3 centre_mm = Vec3::Zero();  // a point of all planes, and of the axis
  int fold = 1;                   // equal parts of a full turn about the axis; 1: no turn
  Axis axis = Axis::z;

  bool mirrors() const { return planes[0] || planes[1] || planes[2]; }
  bool any() const { return mirrors() || fold > 1; }
  bool operator==(const Symmetry&) const = default;
};

// Ok, or a sentence: a centre that is not finite, a fold that is not 1 ... kMaxFold.
Status check_symmetry(const Symmetry& symmetry);

// The middle of the lattice [mm], where rays have rays for images.
Vec3 centre_of(const Lattice& lattice);

// Where an image is: x goes to centre + turn (x - centre).
struct SymmetryImage {
  Mat3 turn = Mat3::Identity();
  bool mirrors = false;  // the determinant of `turn` is -1
};

// The images of a symmetry, without the tool itself; no two are alike. Takes no memory.
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

// A place, a pose of the tool, and its motion, as an image has them. Where the image mirrors, the
// frame of a mesh is left-handed; every other tool is its own image in its local yz plane.
Vec3 image_of(const Vec3& place_mm, const Vec3& centre_mm, const SymmetryImage& image);
Pose image_of(const Pose& pose, const Tool& tool, const Vec3& centre_mm,
              const SymmetryImage& image);
ToolMotion image_of(const ToolMotion& motion, const Tool& tool, const Vec3& centre_mm,
                    const SymmetryImage& image);

}  // namespace kibori
