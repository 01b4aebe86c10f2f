// SPDX-License-Identifier: MIT
// Encodes the normal at a span's end in 32 bits: its u and v components in the field's frame, as
// 16-bit numbers (snorm: 32767 means 1).
//
// The depth component is not stored. Its size follows from the unit length. Its sign follows from
// the kind of end. A normal points out of the material, so the component is <= 0 at an `in` end and
// >= 0 at an `out` end. The typical error is 0.002 degrees. The maximum error is 0.4 degrees, where
// the surface is nearly parallel to the ray. At such places, the other two fields are accurate.
// (The errors of an octahedral code are more even, but it takes three times as long.) Code 0 is a
// normal along the ray.
#pragma once

#include <cmath>
#include <cstdint>

#include <kibori/geometry/axis.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// Rounds to the nearest integer. If two are equally near, rounds to the even one. Requires
// |x| < 2^31. std::nearbyint would be slower, because compilers do not inline it.
inline int32_t nearest_whole(double x) {
  constexpr double kNoFractions = 0x1.8p52;  // a double of this size cannot have a fraction
  return static_cast<int32_t>((x + kNoFractions) - kNoFractions);
}

// Returns the code of a vector with these components, which may have any length. Returns 0 for the
// zero vector.
inline uint32_t encode_normal(double u, double v, double depth) {
  const double norm = std::sqrt(u * u + v * v + depth * depth);
  if (!(norm > 0)) return 0;
  const auto snorm = [](double x) {
    return static_cast<uint32_t>(nearest_whole(x * 32767)) & 0xffffu;
  };
  return snorm(u / norm) | (snorm(v / norm) << 16);
}

// Returns the code of the opposite normal, for an end of the other kind (`in` or `out`).
inline uint32_t negate_normal(uint32_t code) {
  const auto low = static_cast<uint16_t>(-static_cast<int16_t>(code & 0xffffu));
  const auto high = static_cast<uint16_t>(-static_cast<int16_t>(code >> 16));
  return low | (static_cast<uint32_t>(high) << 16);
}

// Size of the normal's depth component, from 0 to 1.
inline double depth_share(uint32_t code) {
  const double u = static_cast<int16_t>(code & 0xffffu) / 32767.0;
  const double v = static_cast<int16_t>(code >> 16) / 32767.0;
  return std::sqrt(std::fmax(0.0, 1 - u * u - v * v));
}

// The square of the normal's depth component, in [0, 1]. volume.h uses it as the weight of an end.
inline constexpr float kHalfSquares = 2 / (32767.0f * 32767.0f);
inline float depth_weight(uint32_t code) {
  const int u = static_cast<int16_t>(code & 0xffffu), v = static_cast<int16_t>(code >> 16);
  // Half the sum of the squares, because the whole sum can exceed a signed integer.
  const uint32_t half = (static_cast<uint32_t>(u * u) + static_cast<uint32_t>(v * v)) >> 1;
  return std::fmax(0.0f, 1 - kHalfSquares * static_cast<float>(half));
}

// Returns the unit normal in world axes. at_out: true for an `out` end, false for an `in` end.
inline Vec3 decode_normal(uint32_t code, Axis axis, bool at_out) {
  const double u = static_cast<int16_t>(code & 0xffffu) / 32767.0;
  const double v = static_cast<int16_t>(code >> 16) / 32767.0;
  const double depth = depth_share(code);
  Vec3 normal;
  normal[u_index(axis)] = u;
  normal[v_index(axis)] = v;
  normal[depth_index(axis)] = at_out ? depth : -depth;
  return normal.normalized();
}

}  // namespace kibori
