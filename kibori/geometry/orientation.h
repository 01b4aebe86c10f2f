// SPDX-License-Identifier: MIT
// A rotation by right angles from the axes of a file to Kibori's; there are 24. It is given by two
// axes of the file: the one that points up, and the one that points to the front.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <kibori/geometry/vec.h>

namespace kibori {

enum class SignedAxis : uint8_t { plus_x, minus_x, plus_y, minus_y, plus_z, minus_z };

// Parses "x", "-x" and so on. Returns nullopt for any other text.
std::optional<SignedAxis> parse_signed_axis(std::string_view text);
const char* signed_axis_text(SignedAxis axis);
// Returns the unit vector along the axis.
Vec3 direction(SignedAxis axis);

// Axis `up` of the file becomes +z. Axis `front` points towards the viewer and becomes -y.
struct Orientation {
  SignedAxis up = SignedAxis::plus_z;
  SignedAxis front = SignedAxis::minus_y;

  bool operator==(const Orientation&) const = default;
};

// Returns the orientation with this `up` and the usual front. If `up` is y (as in glTF) or -y, the
// front is z. Otherwise it is -y.
Orientation standing(SignedAxis up);

// True if `up` and `front` are at right angles. Otherwise the orientation is invalid.
bool is_turn(const Orientation& orientation);

// Returns the rotation from the file's axes to Kibori's. The orientation must be valid (is_turn).
// The entries are 0, 1 and -1, so the rotation is exact.
Mat3 rotation(const Orientation& orientation);

}  // namespace kibori
