// SPDX-License-Identifier: MIT
// Paint and mask of a point of the surface, in one number.
#pragma once

#include <cstdint>

namespace kibori {

// 0xMMBBGGRR. 0: neither painted nor masked. MM encodes the mask and whether there is paint:
//
//   0xff - m   painted, with mask m
//   m          not painted, with mask m; BBGGRR is 0
//
// The mask m is a number from 0 to kMaxMask. Brushes move the surface less where m is larger.
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
// The share of a brush's effect that the mask lets through, 0 to 1.
constexpr double unmasked_share(Color color) {
  return 1 - static_cast<double>(mask_of(color)) / kMaxMask;
}

}  // namespace kibori
