// SPDX-License-Identifier: MIT
// Words, lines and numbers of text files that hold meshes (STL, OBJ, OFF). Internal to `formats`.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <kibori/geometry/mesh.h>

namespace kibori {

// True if a character separates words. This includes NUL, because some programs pad names with it.
inline bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r') || c == '\0'; }
inline bool is_line_end(char c) { return c == '\n' || c == '\r'; }

// Parses a whole word as a finite decimal number; nullopt for any other word.
std::optional<double> parse_number(std::string_view word);

// The first 40 bytes of a word, in quotes, for a message.
std::string in_quotes(std::string_view word);

// The text without a UTF-8 byte order mark.
std::string_view without_bom(std::string_view text);
// True if a text begins with the byte order mark of UTF-16.
bool is_utf16(std::string_view text);

// A line without its comment, which begins with '#'. Old programs write 1.#IND for an undefined
// number; that is not a comment.
std::string_view without_comment(std::string_view line);

// Removes the first word of a text, and returns it; empty at the end.
std::string_view take_word(std::string_view& text);

// The lines of a text. They end with LF, CR or CR LF.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  // Returns false at the end.
  bool next(std::string_view& line);
  int number() const { return number_; }  // number of the line that next returned, from 1

 private:
  std::string_view rest_;
  int number_ = 0;
};

// Rounds all coordinates to float32, so that a text file and a binary file of one mesh give the
// same result. A mesh far from the origin is not changed: no vertex may move by more than a
// millionth of the longest side.
void round_to_float(TriangleMesh& mesh);

}  // namespace kibori
