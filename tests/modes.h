// SPDX-License-Identifier: MIT
// The lists of modes that tests use. They follow Mode, so a new mode is tested without an entry.
#pragma once

#include <cstddef>
#include <vector>

#include <kibori/motion/mode.h>

namespace kibori::test {

// All modes that reshape, in the order of Mode.
inline const std::vector<Mode>& reshaping_modes() {
  static const std::vector<Mode> modes = [] {
    std::vector<Mode> found;
    for (size_t i = 0; i < names_of(Mode{}).size(); i++)
      if (const auto mode = static_cast<Mode>(i); reshapes(mode)) found.push_back(mode);
    return found;
  }();
  return modes;
}

// `random` gives integer(low, high). Draws only from the first `count` modes. To repeat a seed,
// pass the number of modes at the time when the seed was noted.
inline Mode random_reshaping_mode(auto& random, size_t count = reshaping_modes().size()) {
  return reshaping_modes()[static_cast<size_t>(random.integer(0, static_cast<int>(count) - 1))];
}

}  // namespace kibori::test
