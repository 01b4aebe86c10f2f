// SPDX-License-Identifier: MIT
#include <kibori/motion/symmetry.h>

#include <cmath>
#include <numbers>

#include <kibori/base/trig.h>

namespace kibori {
namespace {

// Two images are equal if the norm of the difference of their matrices is at most this. For
// example, a half turn equals two mirrors.
constexpr double kAlike = 1e-9;

// Turn about an axis by k of n parts of a full turn. Quarter turns are exact, so that images of
// rays coincide with rays.
Mat3 part_of_turn(Axis axis, int k, int n) {
  const auto exact = [](double x) {
    const double whole = std::round(x);
    return std::fabs(x - whole) < kAlike ? whole : x;
  };
  const SinCos at = sin_cos(2 * std::numbers::pi * k / n);
  const double sine = exact(at.sin), cosine = exact(at.cos);
  const int u = u_index(axis), v = v_index(axis);
  Mat3 turn = Mat3::Identity();
  turn(u, u) = turn(v, v) = cosine;
  turn(v, u) = sine;
  turn(u, v) = -sine;
  return turn;
}

}  // namespace

Status check_symmetry(const Symmetry& symmetry) {
  if (!symmetry.centre_mm.allFinite()) return Error{"the centre of the symmetry must be finite"};
  if (symmetry.fold < 1 || symmetry.fold > kMaxFold)
    return Error{"a symmetry about an axis must have 1 to 16 parts"};
  return Ok{};
}

Vec3 centre_of(const Lattice& lattice) { return lattice.to_mm(lattice.base().centre()); }

SymmetryImages::SymmetryImages(const Symmetry& symmetry) : centre_mm_(symmetry.centre_mm) {
  for (int k = 0; k < symmetry.fold; k++) {
    const Mat3 turn = part_of_turn(symmetry.axis, k, symmetry.fold);
    for (unsigned planes = 0; planes < 8; planes++) {
      Vec3 signs = Vec3::Ones();
      bool there = true;
      for (unsigned i = 0; i < 3; i++)
        if (planes >> i & 1) {
          signs[i] = -1;
          there &= symmetry.planes[i];
        }
      if (!there) continue;
      const SymmetryImage image{turn * signs.asDiagonal(), signs.prod() < 0};
      bool is_new = !image.turn.isIdentity(kAlike);
      for (const SymmetryImage& other : *this) is_new &= (other.turn - image.turn).norm() > kAlike;
      if (is_new) images_[count_++] = image;
    }
  }
}

Vec3 image_of(const Vec3& place_mm, const Vec3& centre_mm, const SymmetryImage& image) {
  return centre_mm + image.turn * (place_mm - centre_mm);
}

Pose image_of(const Pose& pose, const Tool& tool, const Vec3& centre_mm,
              const SymmetryImage& image) {
  Pose seen;
  seen.tip = image_of(pose.tip, centre_mm, image);
  seen.frame = image.turn * pose.frame;
  // A mirror makes the frame left-handed. The tool's own symmetry makes it right-handed again.
  if (image.mirrors && !std::holds_alternative<MeshTool>(tool))
    seen.frame.col(0) = -seen.frame.col(0);
  return seen;
}

ToolMotion image_of(const ToolMotion& motion, const Tool& tool, const Vec3& centre_mm,
                    const SymmetryImage& image) {
  // A rotation vector is an axial vector: a mirror also reverses it.
  return {image_of(motion.start, tool, centre_mm, image), image.turn * motion.travel_mm,
          (image.mirrors ? -1 : 1) * (image.turn * motion.turn_rad)};
}

}  // namespace kibori
