// SPDX-License-Identifier: MIT
#include <kibori/geometry/vec.h>

#include <kibori/base/trig.h>

namespace kibori {

Mat3 frame_from_axis(const Vec3& axis, double roll_rad) {
  const Vec3 z = axis / std::sqrt(axis.squaredNorm());
  const Vec3 reference = std::abs(z.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  Vec3 x = reference - reference.dot(z) * z;
  x /= std::sqrt(x.squaredNorm());
  Vec3 y = z.cross(x);
  const SinCos roll = sin_cos(roll_rad);
  Mat3 frame;
  frame.col(0) = roll.cos * x + roll.sin * y;
  frame.col(1) = roll.cos * y - roll.sin * x;
  frame.col(2) = z;
  return frame;
}

Vec3 shortest_turn(const Vec3& from, const Vec3& to) {
  const Vec3 normal = from.cross(to);
  const double sine = std::sqrt(normal.squaredNorm());
  if (sine == 0) return Vec3::Zero();
  return normal * (angle_of(sine, from.dot(to)) / sine);
}

Mat3 rotation(const Vec3& rotation_vector) {
  const double angle = std::sqrt(rotation_vector.squaredNorm());
  if (angle == 0) return Mat3::Identity();
  const Vec3 k = rotation_vector / angle;
  const SinCos turn = sin_cos(angle);
  Mat3 cross;
  cross << 0, -k.z(), k.y(), k.z(), 0, -k.x(), -k.y(), k.x(), 0;
  return Mat3::Identity() + turn.sin * cross + (1 - turn.cos) * (cross * cross);
}

Vec3 rotation_between(const Mat3& from, const Mat3& to) {
  const Mat3 r = to * from.transpose();
  Vec3 sine_axis = 0.5 * Vec3(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
  const double sine = std::sqrt(sine_axis.squaredNorm()),
               cosine = 0.5 * (r(0, 0) + r(1, 1) + r(2, 2) - 1);
  if (!(sine > 1e-9)) {
    if (cosine > 0) return sine_axis;  // tiny turns: the sine is the angle
    // Half a turn: R = 2 a a^T - 1.
    int big = 0;
    for (int i = 1; i < 3; i++)
      if (r(i, i) > r(big, big)) big = i;
    Vec3 axis = r.col(big);
    axis[big] += 1;
    return axis * (std::numbers::pi / std::sqrt(axis.squaredNorm()));
  }
  return sine_axis * (angle_of(sine, cosine) / sine);
}

}  // namespace kibori
