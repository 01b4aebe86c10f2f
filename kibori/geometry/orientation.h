// SPDX-License-Identifier: MIT
// The 24 turns by right angles, as which of a file's axes points up and which to the front.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <kibori/geometry/vec.h>

namespace kibori {

enum class SignedAxis : uint8_t { plus_x, minus_x, plus_y, minus_y, plus_z, minus_z };

// "x", "-x" and so on; none for any other text.
std::optional<SignedAxis> parse_signed_axis(std::string_view text);
const char* signed_axis_text(SignedAxis axis);
// The unit vector along it.
Vec3 direction(SignedAxis axis);

// `up` becomes +z, and `front`, what looks at someone who stands before the piece, becomes -y.
struct Orientation {
  SignedAxis up = SignedAxis::plus_z;
  SignedAxis front = SignedAxis::minus_y;

  bool operator==(const Orientation&) const = default;
};

// With the front that is usual for this `up`: z where y is up (as in glTF) or down, else -y.
Orientation standing(SignedAxis up);

// Whether up and front are at right angles, as they must be.
bool is_turn(const Orientation& orientation);

// The rotation from a file's axes to Kibori's. Its entries are 0, 1 and -1, so turning is exact.
Mat3 rotation(const Orientation& orientation);

}  // namespace kibori
