// SPDX-License-Identifier: MIT
// The 24 rotations by right angles, given as the axes of a file that point up and to the front.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <kibori/geometry/vec.h>

namespace kibori {

enum class SignedAxis : uint8_t { plus_x, minus_x, plus_y, minus_y, plus_z, minus_z };

// "x", "-x" and so on; nullopt for any other text.
std::optional<SignedAxis> parse_signed_axis(std::string_view text);
const char* signed_axis_text(SignedAxis axis);
// The unit vector along the axis.
Vec3 direction(SignedAxis axis);

// `up` becomes +z. `front`, the side that faces the viewer, becomes -y.
struct Orientation {
  SignedAxis up = SignedAxis::plus_z;
  SignedAxis front = SignedAxis::minus_y;

  bool operator==(const Orientation&) const = default;
};

// The orientation with this `up` and the usual front: z if y is up (as in glTF) or down, otherwise
// -y.
Orientation standing(SignedAxis up);

// True if up and front are at right angles, as they must be.
bool is_turn(const Orientation& orientation);

// The rotation from a file's axes to Kibori's. Its entries are 0, 1 and -1, so the rotation is
// exact.
Mat3 rotation(const Orientation& orientation);

}  // namespace kibori
