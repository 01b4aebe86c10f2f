// SPDX-License-Identifier: MIT
// The canned cycles G73, G81, G82, G83, G85 and G89. Each line of a cycle drills one hole, or L
// holes.
//
//   start  ────► above the hole          rapid
//                   │
//   R      ─────────┼──                  rapid; feed begins here
//                   │
//   bottom ─────────┴──                  feed, dwell, and back
//
// After the hole the tool is at R (G99), or at the height where the series began (G98).
#include <algorithm>
#include <cmath>

#include <kibori/mill/gcode_block.h>
#include <kibori/mill/interpreter.h>

namespace kibori {
namespace {

// Maximum number of holes of one line, so that a damaged file cannot run for hours.
constexpr double kMaxRepeats = 10000;
// Maximum number of steps of one pecked hole.
constexpr double kMaxPecks = 10000;
// In G83, a rapid move returns to this height [mm] above the bottom of the last step. In G73, the
// tool lifts by it after each step. It is 0.010 inch, as in LinuxCNC.
constexpr double kPeckGap = 0.254;

}  // namespace

void Interpreter::go_to(double height, bool feed) {
  AxisPosition to = at_;
  to.xyz_mm[axes_of(plane_).normal] = height;
  feed ? feed_to(to) : rapid_to(to);
}

// Words of a cycle stay in force for the next holes.
Status Interpreter::read_cycle(const GcodeBlock& block, bool first) {
  const char depth = "XYZ"[axes_of(plane_).normal];
  if (const auto& z = block.value(depth)) cycle_.bottom = *z * scale();
  if (const auto& r = block.value('R')) cycle_.clear = *r * scale();
  if (const auto& q = block.value('Q')) cycle_.step = *q * scale();
  if (const auto& p = block.value('P')) cycle_.dwell = *p;
  const std::string name = code_text('G', motion_);
  if (!cycle_.bottom)
    return Error{name + " needs the bottom of the hole as " + std::string(1, depth)};
  if (!cycle_.clear) return Error{name + " needs the height where feed begins as R"};
  if ((motion_ == 730 || motion_ == 830) && !(cycle_.step && *cycle_.step > 0))
    return Error{name + " needs the depth of a step as Q, above 0"};
  if ((motion_ == 820 || motion_ == 890) &&
      !(cycle_.dwell && *cycle_.dwell >= 0 && *cycle_.dwell <= 1e6))
    return Error{name + " needs the time at the bottom as P, in seconds"};
  if (block.has('A') || block.has('B') || block.has('C'))
    return Error{name + " cannot turn a rotary axis; turn it on a separate line"};
  if (feed_.mode == FeedMode::inverse_time)
    return Error{name + " needs a feed rate per minute or revolution; write G94"};
  if (first) cycle_.from_mm = at_.xyz_mm[axes_of(plane_).normal];
  return Ok{};
}

Status Interpreter::cycle(const GcodeBlock& block) {
  const auto [u, v, w] = axes_of(plane_);
  const bool first = !cycle_.bottom;
  if (const Status ok = read_cycle(block, first); !ok) return ok;
  int repeats = 1;
  if (const auto& l = block.value('L')) {
    if (!(*l >= 1 && *l <= kMaxRepeats) || std::abs(*l - std::round(*l)) > 1e-4)
      return Error{word_text('L', *l) + " is not a number of holes; use a whole number from 1"};
    repeats = static_cast<int>(std::round(*l));
  }
  const double from = at_.xyz_mm[w];
  const double clear = incremental_ ? from + *cycle_.clear : *cycle_.clear + offset(w);
  const double bottom = incremental_ ? clear + *cycle_.bottom : *cycle_.bottom + offset(w);
  if (!(clear >= bottom))
    return Error{code_text('G', motion_) +
                 " has its R below the bottom of the hole (Z); R is where the feed begins"};
  if (cycle_.step && (clear - bottom) / *cycle_.step > kMaxPecks)
    return Error{code_text('G', motion_) + " needs more than 10000 steps for one hole; raise Q"};
  for (int i = 0; i < repeats; i++) {
    AxisPosition to = at_;
    for (const int axis : {u, v}) {
      const auto& value = block.value("XYZ"[axis]);
      if (!value) continue;
      to.xyz_mm[axis] =
          incremental_ ? to.xyz_mm[axis] + *value * scale() : *value * scale() + offset(axis);
      known_[static_cast<size_t>(axis)] = Known::yes;
    }
    const double retract =
        retract_to_clear_ ? clear : std::max(clear, incremental_ ? from : cycle_.from_mm);
    drill(to, clear, bottom, retract);
  }
  return Ok{};
}

// Drills one hole.
void Interpreter::drill(const AxisPosition& to, double clear, double bottom, double retract) {
  const int w = axes_of(plane_).normal;
  // A tool below R first rises to R, so that its path to the hole is clear.
  if (at_.xyz_mm[w] < clear) go_to(clear, false);
  AxisPosition above = to;
  above.xyz_mm[w] = at_.xyz_mm[w];
  if (!(above == at_)) rapid_to(above);
  if (at_.xyz_mm[w] != clear) {
    known_[static_cast<size_t>(w)] = Known::yes;
    go_to(clear, false);
  }
  if (motion_ == 730 || motion_ == 830)
    peck(clear, bottom);
  else
    go_to(bottom, true);
  if (motion_ == 820 || motion_ == 890) add(Dwell{*cycle_.dwell});
  const bool feeds_back = motion_ == 850 || motion_ == 890;
  if (feeds_back) go_to(clear, true);
  if (at_.xyz_mm[w] != retract) go_to(retract, false);
}

// Drills one hole in steps. After each step, G83 leaves the hole, and G73 lifts by kPeckGap.
void Interpreter::peck(double clear, double bottom) {
  const double step = *cycle_.step;
  for (double depth = clear - step; depth > bottom; depth -= step) {
    go_to(depth, true);
    if (motion_ == 730) {
      go_to(depth + kPeckGap, false);
      continue;
    }
    go_to(clear, false);
    go_to(depth + kPeckGap, false);
  }
  go_to(bottom, true);
}

}  // namespace kibori
