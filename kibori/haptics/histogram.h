// SPDX-License-Identifier: MIT
// Counts durations in bins. Each octave (factor of two) has 32 equal bins. Therefore, a quantile is
// at most 3.2 % too high. A histogram allocates no memory. Adding a value takes a few instructions.
#pragma once

#include <array>
#include <cstddef>
#include <bit>
#include <cstdint>

namespace kibori {

class Histogram {
 public:
  // Adds a duration [ns]. A negative duration counts as 0.
  void add(int64_t ns) {
    const auto value = static_cast<uint64_t>(ns < 0 ? 0 : ns);
    bins_[bin_of(value)]++;
    count_++;
    if (value > max_) max_ = value;
  }
  uint64_t count() const { return count_; }
  uint64_t max_ns() const { return max_; }
  // Returns the upper end of the bin that contains the quantile `share` (0 ... 1) [ns]. Returns 0
  // if the histogram is empty.
  uint64_t quantile_ns(double share) const {
    const auto wanted = static_cast<uint64_t>(share * static_cast<double>(count_));
    uint64_t seen = 0;
    for (size_t i = 0; i < bins_.size(); i++) {
      seen += bins_[i];
      if (seen > wanted || (seen == count_ && seen > 0)) return end_of(i) < max_ ? end_of(i) : max_;
    }
    return 0;
  }
  // Calls f(from_ns, to_ns, count) for every bin that is not empty.
  template <class F>
  void for_bins(F&& f) const {
    for (size_t i = 0; i < bins_.size(); i++)
      if (bins_[i] > 0) f(i == 0 ? 0 : end_of(i - 1), end_of(i), bins_[i]);
  }

 private:
  static constexpr uint64_t kParts = 32;
  // Each value below kParts has its own bin. Larger values: each octave has kParts bins.
  static size_t bin_of(uint64_t value) {
    if (value < kParts) return static_cast<size_t>(value);
    // value >> octave is in [32, 64).
    const int octave = static_cast<int>(std::bit_width(value)) - 6;
    const auto bin = static_cast<size_t>(octave) * kParts + static_cast<size_t>(value >> octave);
    return bin < kBins ? bin : kBins - 1;
  }
  static uint64_t end_of(size_t bin) {
    if (bin < 2 * kParts) return bin + 1;
    const size_t octave = bin / kParts - 1;
    return (bin % kParts + kParts + 1) << octave;
  }
  static constexpr size_t kBins = 36 * kParts;  // up to 2^40 ns, about 18 minutes

  std::array<uint64_t, kBins> bins_{};
  uint64_t count_ = 0, max_ = 0;
};

}  // namespace kibori
