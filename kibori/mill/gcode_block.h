// SPDX-License-Identifier: MIT
// One line of G-code, checked and sorted by modal group. Internal: not installed.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/mill/gcode_parser.h>

namespace kibori {

// Groups of G-codes. A line may have one code of each group.
enum class GGroup {
  non_modal,  // G4, G28, G30, G92, ...
  motion,
  plane,
  distance,
  arc_distance,
  feed_mode,
  units,
  cutter,
  length,
  retract,
  work_offset,
  path,
  machine,  // G53
  kCount
};

// Groups of M-codes.
enum class MGroup { stop, tool, spindle, kCount };

// Codes are ten times their number: G59.1 is 591, M6 is 60.
inline constexpr int kNoCode = -1;

struct GcodeBlock {
  std::array<int, static_cast<size_t>(GGroup::kCount)> g;
  std::array<int, static_cast<size_t>(MGroup::kCount)> m;
  std::vector<int> coolant;                      // 70, 80, 90
  std::vector<int> user;                         // M-codes that are not known, as plain numbers
  std::array<std::optional<double>, 26> values;  // by letter; none for G, M, N and O

  int code(GGroup group) const { return g[static_cast<size_t>(group)]; }
  int code(MGroup group) const { return m[static_cast<size_t>(group)]; }
  const std::optional<double>& value(char letter) const {
    return values[static_cast<size_t>(letter - 'A')];
  }
  bool has(char letter) const { return value(letter).has_value(); }
  // True if the line names any of the axes X Y Z A B C.
  bool has_axis() const;
};

// Errors: one sentence without file and line: a code that is unknown or not supported, two codes of
// one group, a letter twice, a word U, V, W or E.
Result<GcodeBlock> make_block(const GcodeLine& line);

// Text of a code, as in "G59.1".
std::string code_text(char letter, int code10);

}  // namespace kibori
