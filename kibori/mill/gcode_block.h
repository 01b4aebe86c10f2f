// SPDX-License-Identifier: MIT
// One line of G-code, checked and sorted by modal group (codes that replace each other). Internal:
// not installed.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/mill/gcode_parser.h>

namespace kibori {

// The groups of G-codes. A line may have one code of each group.
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

// The groups of M-codes.
enum class MGroup { stop, tool, spindle, kCount };

// Codes are stored as ten times their number: G59.1 is 591, M6 is 60.
inline constexpr int kNoCode = -1;

struct GcodeBlock {
  std::array<int, static_cast<size_t>(GGroup::kCount)> g;
  std::array<int, static_cast<size_t>(MGroup::kCount)> m;
  std::vector<int> coolant;                      // codes: 70, 80, 90
  std::vector<int> user;                         // unknown M-codes, not multiplied by ten
  std::array<std::optional<double>, 26> values;  // for each letter; none for G, M, N and O

  int code(GGroup group) const { return g[static_cast<size_t>(group)]; }
  int code(MGroup group) const { return m[static_cast<size_t>(group)]; }
  const std::optional<double>& value(char letter) const {
    return values[static_cast<size_t>(letter - 'A')];
  }
  bool has(char letter) const { return value(letter).has_value(); }
  // Returns true if the line has a word with one of the letters X Y Z A B C.
  bool has_axis() const;
};

// Makes a block of a line. Errors (without file and line): a code is unknown or not supported; two
// codes are of one group; a letter occurs twice; there is a word U, V, W or E.
Result<GcodeBlock> make_block(const GcodeLine& line);

// Returns the text of a code, for example "G59.1".
std::string code_text(char letter, int code10);

}  // namespace kibori
