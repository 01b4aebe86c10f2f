// SPDX-License-Identifier: MIT
// Writes a copy of a program with other feed rates. Only F words change: they get another number,
// or are added at the end of a line. The path stays the same.
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

// Limits of the estimated force and power of a line, at its programmed speed.
struct FeedLimits {
  double force_n = std::numeric_limits<double>::infinity();
  double power_w = std::numeric_limits<double>::infinity();
  double min_mm_min = 1;             // no rate becomes smaller than this
  std::optional<double> max_mm_min;  // for lines in material; none: as programmed
};

// Parses one limit: "force=50", "power=300", "min=100" or "max=2000". Errors: the key is unknown;
// the number is not positive.
Status set_feed_limit(FeedLimits& limits, const std::string& text);

// Rewrites the lines of one program. Lines must come in order.
class FeedRewriter {
 public:
  explicit FeedRewriter(InterpreterOptions controller) : interpreter_(std::move(controller)) {}

  // Returns the text of a line whose feed rates are multiplied by `factor`. `number` is the number
  // of the line. A changed rate is rounded down. Errors: those of parse_gcode and of the
  // interpreter.
  Result<std::string> rewrite(std::string_view line, int number, double factor);

 private:
  Interpreter interpreter_;
  // The F number that is active in a controller. Empty: unknown, because controllers behave
  // differently after a change of the unit or the mode.
  std::string modal_;
  bool changed_ = false;  // true if the rate of an earlier line was changed
};

// Writes a whole program. factor(line) returns the factor of a line. Errors (with file and line):
// those of FeedRewriter::rewrite; the program is a canonical listing; a file cannot be read or
// written.
Status write_refed(const std::filesystem::path& program, const std::filesystem::path& to,
                   const InterpreterOptions& controller,
                   const std::function<double(int line)>& factor);

}  // namespace kibori
