// SPDX-License-Identifier: MIT
// The paint and the mask of a point of the surface, in one number. A mask protects the surface from
// brushes.
#pragma once

#include <cstdint>

namespace kibori {

// The bytes are 0xMMBBGGRR. 0 means neither painted nor masked. MM encodes the mask m, and whether
// there is paint:
//
//   0xff - m   painted, with mask m
//   m          not painted, with mask m; BBGGRR is 0
//
// m is a number from 0 to kMaxMask. The larger it is, the less brushes move the surface.
using Color = uint32_t;
inline constexpr int kMaxMask = 127;

constexpr bool is_painted(Color color) { return color >> 31; }
constexpr int mask_of(Color color) {
  const auto high = static_cast<int>(color >> 24);
  return is_painted(color) ? 0xff - high : high;
}
constexpr Color with_mask(Color color, int mask) {
  const auto high = static_cast<Color>(is_painted(color) ? 0xff - mask : mask);
  return (color & 0xffffff) | high << 24;
}
// Returns the share of a brush's effect that remains with this mask: 1 without a mask, 0 at
// kMaxMask.
constexpr double unmasked_share(Color color) {
  return 1 - static_cast<double>(mask_of(color)) / kMaxMask;
}

}  // namespace kibori
