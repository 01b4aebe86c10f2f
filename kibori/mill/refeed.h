// SPDX-License-Identifier: MIT
// Writes a program again with other feed rates. Only F words change. They get another number, or
// are added at the end of a line. The path stays the same.
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include <kibori/base/result.h>
#include <kibori/mill/interpreter.h>

namespace kibori {

// Limits of the estimated force and power of a line, at its commanded speed.
struct FeedLimits {
  double force_n = std::numeric_limits<double>::infinity();
  double power_w = std::numeric_limits<double>::infinity();
  double min_mm_min = 1;             // no rate is reduced below this
  std::optional<double> max_mm_min;  // of lines in material; none: as programmed
};

// Parses "force=50", "power=300", "min=100", "max=2000". Errors: an unknown key, a number that is
// not positive.
Status set_feed_limit(FeedLimits& limits, const std::string& text);

// Rewrites the lines of one program, in order.
class FeedRewriter {
 public:
  explicit FeedRewriter(InterpreterOptions controller) : interpreter_(std::move(controller)) {}

  // The text of a line whose feed moves get `factor` times their feed rate. `number`: of the line.
  // A changed rate is rounded down. Errors: those of the interpreter.
  Result<std::string> rewrite(std::string_view line, int number, double factor);

 private:
  Interpreter interpreter_;
  // The F number that is in force in a controller. Empty: unknown, because after a change of unit
  // or mode controllers differ.
  std::string modal_;
  bool changed_ = false;  // the rate of an earlier line was changed
};

// Writes a whole program. `factor` returns the factor of a line. Errors: those above, with file and
// line; a canonical listing; a file that cannot be read or written.
Status write_refed(const std::filesystem::path& program, const std::filesystem::path& to,
                   const InterpreterOptions& controller,
                   const std::function<double(int line)>& factor);

}  // namespace kibori
