// SPDX-License-Identifier: MIT
// A 64-bit hash of content. The order of the values matters. The hash mixes values as integers, so
// it is the same on all platforms. It is not cryptographic.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

namespace kibori {

// Accumulates values. After a call of value(), more values may be added.
class Hash {
 public:
  void add(uint64_t value) {
    // The finaliser of splitmix64 (Steele, Lea, Flood 2014) on a running state.
    state_ = (state_ ^ value) + 0x9e3779b97f4a7c15u;
    state_ = (state_ ^ (state_ >> 30)) * 0xbf58476d1ce4e5b9u;
    state_ = (state_ ^ (state_ >> 27)) * 0x94d049bb133111ebu;
    state_ ^= state_ >> 31;
  }
  void add(float value) { add(uint64_t{std::bit_cast<uint32_t>(value)}); }
  void add(double value) { add(std::bit_cast<uint64_t>(value)); }
  // Adds `count`, and then the bytes in words of eight bytes. The first byte of a word is its
  // lowest one.
  void add(const uint8_t* bytes, size_t count) {
    add(uint64_t{count});
    for (size_t i = 0; i < count; i += 8) {
      uint64_t word = 0;
      for (size_t j = i; j < std::min(i + 8, count); j++)
        word |= uint64_t{bytes[j]} << (8 * (j - i));
      add(word);
    }
  }
  uint64_t value() const { return state_; }

 private:
  uint64_t state_ = 0x6b69626f7269ull;
};

// Returns a hash as 16 hexadecimal digits, for people and documents.
inline std::string hash_text(uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace kibori
