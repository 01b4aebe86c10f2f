// SPDX-License-Identifier: MIT
// Splits a line of G-code into words. The parser does not interpret the words.
//
// The notation is that of LinuxCNC (RS274/NGC). Upper and lower case mean the same. Spaces and tabs
// are ignored, even within a number. A comment is in (...), or goes from ; to the end of the line.
// A line that begins with / is optional. A line with only % begins or ends a program.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>

namespace kibori {

// Maximum length of a line [bytes]. LinuxCNC accepts 255. Lines of post-processors may be longer,
// because they have long comments.
inline constexpr size_t kMaxGcodeLine = 4096;

// Maximum absolute value of a number in a word. Larger numbers occur only in damaged files.
inline constexpr double kMaxGcodeNumber = 1e9;

struct GcodeWord {
  char letter = 0;  // upper case
  double value = 0;
};

// The kind of a line. words: words and comments. percent: only %. deleted: begins with a slash.
enum class GcodeLineKind { words, percent, deleted };

struct GcodeLine {
  GcodeLineKind kind = GcodeLineKind::words;
  std::vector<GcodeWord> words;       // in their order in the line
  std::vector<std::string> comments;  // without their brackets

  // Returns the first word with this letter, or null.
  const GcodeWord* find(char letter) const;
};

// Parses one line, without its line end. Errors (without file and line): a character does not begin
// a word; a letter has no number; a number is not decimal, or is too large; a comment has no end;
// the line is longer than kMaxGcodeLine; the line has a parameter, an expression or an O-word (then
// the sentence ends with need_rs274()).
Result<GcodeLine> parse_gcode(std::string_view text);

// Returns the text of a word, for example "G2" or "X-1.5".
std::string word_text(char letter, double value);

// Returns the end of an error sentence: how to translate the program by LinuxCNC's interpreter.
std::string need_rs274();

}  // namespace kibori
