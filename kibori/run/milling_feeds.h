// SPDX-License-Identifier: MIT
// Computes feed rates that keep the estimated force and power of every line within limits.
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

// The differences between the new program and the old one.
struct FeedReport {
  FeedLimits limits;
  int64_t slower = 0, faster = 0;  // numbers of lines
  double lowest_mm_min = 0;        // lowest new feed rate of all changed lines
  // Lines that exceed a limit even at the rate min_mm_min. At most kMaxFeedLines are listed.
  std::vector<int> over;
  int64_t more_over = 0;
};
inline constexpr size_t kMaxFeedLines = 1000;

class FeedPlan {
 public:
  explicit FeedPlan(const FeedLimits& limits) { report_.limits = limits; }

  // Adds a line of the program. Pass this function to MillOptions::line.
  void add(const MillLine& line);
  // Returns the factor for the feed rate of a line; 1 if the line does not change.
  double factor(int line) const;
  // Writes `program` with the new feed rates to the file `to`. Errors: the force of a line is
  // unknown; those of write_refed.
  Status write(const std::filesystem::path& program, const std::filesystem::path& to,
               const InterpreterOptions& controller) const;
  const FeedReport& report() const { return report_; }

 private:
  FeedReport report_;
  std::unordered_map<int, double> factors_;  // for each line; 1 for lines that are not listed
  int unknown_line_ = 0, unknown_tool_ = 0;
};

}  // namespace kibori
