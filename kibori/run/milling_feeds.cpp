// SPDX-License-Identifier: MIT
#include <kibori/run/milling_feeds.h>

#include <algorithm>

namespace kibori {

void FeedPlan::add(const MillLine& line) {
  if (!line.feed_factor) return;
  if (line.force_unknown && unknown_line_ == 0) {
    unknown_line_ = line.line;
    unknown_tool_ = line.tool;
  }
  const FeedLimits& limits = report_.limits;
  const double feed = line.feed_mm_min;
  // A move of rotary axes alone has no speed in mm/min. So the limits in mm/min do not apply, and
  // the move never becomes faster.
  double factor = *line.feed_factor, lowest = 0;
  if (feed > 0) {
    factor = std::min(factor, limits.max_mm_min ? std::max(*limits.max_mm_min, 0.0) / feed : 1);
    lowest = std::min(limits.min_mm_min / feed, 1.0);
  } else {
    factor = std::min(factor, 1.0);
  }
  if (factor < lowest) {
    if (report_.over.size() < kMaxFeedLines)
      report_.over.push_back(line.line);
    else
      report_.more_over++;
    factor = lowest;
  }
  if (factor == 1) return;
  (factor < 1 ? report_.slower : report_.faster)++;
  const double rate = factor * feed;
  if (rate > 0)
    report_.lowest_mm_min =
        report_.lowest_mm_min > 0 ? std::min(report_.lowest_mm_min, rate) : rate;
  factors_[line.line] = factor;
}

double FeedPlan::factor(int line) const {
  const auto found = factors_.find(line);
  return found == factors_.end() ? 1 : found->second;
}

Status FeedPlan::write(const std::filesystem::path& program, const std::filesystem::path& to,
                       const InterpreterOptions& controller) const {
  if (unknown_line_ > 0)
    return Error{program.string() + ":" + std::to_string(unknown_line_) + ": the force on tool " +
                 std::to_string(unknown_tool_) +
                 " is unknown; --feed-for needs its teeth in the tool table, and a spindle speed "
                 "(S, M3) and a feed rate (F) in the program"};
  return write_refed(program, to, controller, [this](int line) { return factor(line); });
}

}  // namespace kibori
