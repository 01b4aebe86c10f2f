// SPDX-License-Identifier: MIT
#include <kibori/geometry/orientation.h>

#include <array>

#include <kibori/base/check.h>

namespace kibori {
namespace {

constexpr std::array<const char*, 6> kNames = {"x", "-x", "y", "-y", "z", "-z"};

int axis_index(SignedAxis axis) { return static_cast<int>(axis) / 2; }

}  // namespace

std::optional<SignedAxis> parse_signed_axis(std::string_view text) {
  for (size_t i = 0; i < kNames.size(); i++)
    if (text == kNames[i]) return static_cast<SignedAxis>(i);
  return std::nullopt;
}

const char* signed_axis_text(SignedAxis axis) { return kNames[static_cast<size_t>(axis)]; }

Vec3 direction(SignedAxis axis) {
  Vec3 along = Vec3::Zero();
  along[axis_index(axis)] = static_cast<int>(axis) % 2 == 0 ? 1 : -1;
  return along;
}

Orientation standing(SignedAxis up) {
  return {up, axis_index(up) == 1 ? SignedAxis::plus_z : SignedAxis::minus_y};
}

bool is_turn(const Orientation& orientation) {
  return axis_index(orientation.up) != axis_index(orientation.front);
}

Mat3 rotation(const Orientation& orientation) {
  KIBORI_CHECK(is_turn(orientation));
  const Vec3 up = direction(orientation.up), front = direction(orientation.front);
  Mat3 turn;
  turn.row(0) = up.cross(front);
  turn.row(1) = -front;
  turn.row(2) = up;
  return turn;
}

}  // namespace kibori
