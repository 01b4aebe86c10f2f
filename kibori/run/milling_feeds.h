// SPDX-License-Identifier: MIT
// Feed rates that keep the estimated force and power of every line within limits.
//
//   run_milling with feed_limits ─► MillLine ─► FeedPlan ─► write_refed
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/mill/refeed.h>
#include <kibori/run/milling.h>

namespace kibori {

// Differences of the new program from the old one.
struct FeedReport {
  FeedLimits limits;
  int64_t slower = 0, faster = 0;  // number of lines
  double lowest_mm_min = 0;        // lowest new feed rate of these lines
  // Lines that exceed a limit even at min_mm_min, at most kMaxFeedLines.
  std::vector<int> over;
  int64_t more_over = 0;
};
inline constexpr size_t kMaxFeedLines = 1000;

class FeedPlan {
 public:
  explicit FeedPlan(const FeedLimits& limits) { report_.limits = limits; }

  // Adds a line of the program. MillOptions::line is called with these lines.
  void add(const MillLine& line);
  // Factor of a line's feed rate; 1 if the line is unchanged.
  double factor(int line) const;
  // Writes `program` with the new feed rates to `to`. Errors: a line whose force is unknown; those
  // of write_refed.
  Status write(const std::filesystem::path& program, const std::filesystem::path& to,
               const InterpreterOptions& controller) const;
  const FeedReport& report() const { return report_; }

 private:
  FeedReport report_;
  std::unordered_map<int, double> factors_;  // by line; lines that are not listed have 1
  int unknown_line_ = 0, unknown_tool_ = 0;
};

}  // namespace kibori
