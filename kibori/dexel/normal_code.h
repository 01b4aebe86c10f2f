// SPDX-License-Identifier: MIT
// Encodes a surface normal at a span's end in 32 bits: its u and v components (the field's frame)
// as 16-bit snorm numbers.
//
// The depth component follows: its size from the unit length, its sign from the end. A normal
// points out of the material. Its depth component is <= 0 at an `in` end and >= 0 at an `out` end.
// The typical error is 0.002 degrees. The maximum is 0.4, where the surface is within half a degree of
// parallel to the ray; there the other two fields are accurate. (An octahedral code spreads its
// error evenly, but costs three times as much.) Code 0 is the ray's own
// direction.
#pragma once

#include <cmath>
#include <cstdint>

#include <kibori/geometry/axis.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// The nearest integer; of two the even one; |x| < 2^51. (std::nearbyint is a function call.)
inline int32_t nearest_whole(double x) {
  constexpr double kNoFractions = 0x1.8p52;  // so large that doubles of its size have no fractions
  return static_cast<int32_t>((x + kNoFractions) - kNoFractions);
}

// u, v, depth: components of a vector that is not zero. It need not be normalised.
inline uint32_t encode_normal(double u, double v, double depth) {
  const double norm = std::sqrt(u * u + v * v + depth * depth);
  if (!(norm > 0)) return 0;
  const auto snorm = [](double x) {
    return static_cast<uint32_t>(nearest_whole(x * 32767)) & 0xffffu;
  };
  return snorm(u / norm) | (snorm(v / norm) << 16);
}

// The code of the opposite direction.
inline uint32_t negate_normal(uint32_t code) {
  const auto low = static_cast<uint16_t>(-static_cast<int16_t>(code & 0xffffu));
  const auto high = static_cast<uint16_t>(-static_cast<int16_t>(code >> 16));
  return low | (static_cast<uint32_t>(high) << 16);
}

// Size of the depth component of the unit normal.
inline double depth_share(uint32_t code) {
  const double u = static_cast<int16_t>(code & 0xffffu) / 32767.0;
  const double v = static_cast<int16_t>(code >> 16) / 32767.0;
  return std::sqrt(std::fmax(0.0, 1 - u * u - v * v));
}

// The square of the depth component of the unit normal, in [0, 1]: the weight of an end in volumes
// (volume.h).
inline float depth_weight(uint32_t code) {
  constexpr float kUnit2 = 1 / (32767.0f * 32767.0f);
  const auto u = static_cast<float>(static_cast<int16_t>(code & 0xffffu));
  const auto v = static_cast<float>(static_cast<int16_t>(code >> 16));
  return std::fmax(0.0f, 1 - kUnit2 * (u * u + v * v));
}

// Unit normal in world axes. at_out: true for an `out` end.
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
