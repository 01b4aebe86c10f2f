// SPDX-License-Identifier: MIT
// Reads words, lines and numbers of mesh files in text formats (STL, OBJ, OFF). Internal to
// `formats`.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <kibori/geometry/mesh.h>

namespace kibori {

// Returns true if a character separates words. NUL does, because some programs pad names with NUL.
inline bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r') || c == '\0'; }
inline bool is_line_end(char c) { return c == '\n' || c == '\r'; }

// Parses a whole word as a finite decimal number. Returns nullopt for any other word.
std::optional<double> parse_number(std::string_view word);

// Returns the first 40 bytes of a word in quotes, for a message.
std::string in_quotes(std::string_view word);

// Returns the text without a UTF-8 byte order mark.
std::string_view without_bom(std::string_view text);
// Returns true if the text begins with the byte order mark of UTF-16.
bool is_utf16(std::string_view text);

// Returns a line without its comment, which begins with '#'. In 1.#IND, which old programs write
// for an undefined number, '#' does not begin a comment.
std::string_view without_comment(std::string_view line);

// Removes the first word of a text and returns it. Returns an empty word at the end.
std::string_view take_word(std::string_view& text);

// Reads a text line by line. A line ends with LF, CR or CR LF.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  // Writes the next line to `line`. Returns false at the end.
  bool next(std::string_view& line);
  int number() const { return number_; }  // number of the last line, from 1

 private:
  std::string_view rest_;
  int number_ = 0;
};

// Rounds all coordinates to float32, so that the text file and the binary file of a mesh give the
// same result. If a vertex would move by more than a millionth of the longest side (because the
// mesh is far from the origin), changes nothing.
void round_to_float(TriangleMesh& mesh);

}  // namespace kibori
