// SPDX-License-Identifier: MIT
#include <kibori/edit/removed.h>

#include <algorithm>

namespace kibori {

double CellSet::gaps() const {
  int runs = 0;
  for (size_t i = 0; i < 4; i++)
    runs += std::popcount(words_[i] & ~(words_[i] << 1 | words_[(i + 3) % 4] >> 63));
  if (runs < 2) return 0;
  // The longest empty run around the circle. The remaining cells are the extent of the set.
  int count = 0, run = 0, longest = 0;
  for (int i = 0; i < 2 * kCells; i++) {
    const auto cell = static_cast<size_t>(i % kCells);
    const bool in = (words_[cell / 64] >> (cell % 64)) & 1;
    if (in && i < kCells) count++;
    run = in ? 0 : run + 1;
    longest = std::max(longest, run);
  }
  return 1 - static_cast<double>(count) / (kCells - longest);
}

std::array<CellSet, 3> Removed::cells() const {
  std::array<CellSet, 3> all{};
  for_parts([&](int, const RemovedPart& part) {
    for (size_t i = 0; part.has_chip && i < 3; i++) all[i].add(part.chip().cells[i]);
  });
  return all;
}

}  // namespace kibori
