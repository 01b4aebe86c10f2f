// SPDX-License-Identifier: MIT
// Splits a line of G-code into words. It knows the notation, not the meaning of a word.
//
// The notation is that of LinuxCNC (RS274/NGC). Case, spaces and tabs have no meaning, even within
// a number. Comments are (...) and ; to the end of the line. A line that begins with / is optional.
// A line with only % marks the beginning or the end of a program.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>

namespace kibori {

// Maximum length of a line [bytes]. LinuxCNC accepts 255. Longer lines of post-processors have long
// comments.
inline constexpr size_t kMaxGcodeLine = 4096;

// Maximum absolute value of a number in a word. Only a damaged file has a larger one.
inline constexpr double kMaxGcodeNumber = 1e9;

struct GcodeWord {
  char letter = 0;  // upper case
  double value = 0;
};

// The kind of a line: words and comments, a percent sign, or a line that begins with a slash.
enum class GcodeLineKind { words, percent, deleted };

struct GcodeLine {
  GcodeLineKind kind = GcodeLineKind::words;
  std::vector<GcodeWord> words;       // in the order of the line
  std::vector<std::string> comments;  // without their brackets

  // The first word with this letter; null if there is none.
  const GcodeWord* find(char letter) const;
};

// Parses one line without its end. Errors: one sentence without file and line: a character that
// does not begin a word; a letter without a number; a number that is not decimal or is too large; a
// comment without its end; a line longer than kMaxGcodeLine; parameters, expressions and O-words,
// for which the sentence ends with need_rs274().
Result<GcodeLine> parse_gcode(std::string_view text);

// Text of a word, as in "G2" or "X-1.5".
std::string word_text(char letter, double value);

// The end of an error sentence. It says how to translate a program by LinuxCNC's interpreter.
std::string need_rs274();

}  // namespace kibori
