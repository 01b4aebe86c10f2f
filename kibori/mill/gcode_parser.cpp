// SPDX-License-Identifier: MIT
#include <kibori/mill/gcode_parser.h>

#include <charconv>
#include <cmath>
#include <cstdio>

namespace kibori {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool is_digit(char c) { return '0' <= c && c <= '9'; }
char upper(char c) { return 'a' <= c && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

// Separates comments from the rest. Removes blanks and changes the rest to upper case.
class Splitter {
 public:
  explicit Splitter(std::string_view text) : text_(text) {}

  Status run(std::string& code, std::vector<std::string>& comments) {
    for (size_t i = 0; i < text_.size(); i++) {
      const char c = text_[i];
      if (is_blank(c)) continue;
      if (c == ';') {
        comments.emplace_back(text_.substr(i + 1));
        return Ok{};
      }
      if (c != '(') {
        code += upper(c);
        continue;
      }
      const size_t end = text_.find(')', i);
      if (end == std::string_view::npos)
        return Error{"a comment begins with ( and does not end on its line; add a )"};
      if (text_.substr(i + 1, end - i - 1).find('(') != std::string_view::npos)
        return Error{"a comment contains another (; remove the inner one"};
      comments.emplace_back(text_.substr(i + 1, end - i - 1));
      i = end;
    }
    return Ok{};
  }

 private:
  std::string_view text_;
};

// One sentence about a character that does not begin a word.
Error unknown_character(char c) {
  if (c == '#') return Error{"a parameter (#) needs LinuxCNC's interpreter; " + need_rs274()};
  if (c == '[') return Error{"an expression ([ ]) needs LinuxCNC's interpreter; " + need_rs274()};
  char text[80];
  if (c > ' ' && c < 0x7f)
    std::snprintf(text, sizeof text, "'%c' does not begin a word; a word is a letter and a number",
                  c);
  else
    std::snprintf(text, sizeof text,
                  "byte 0x%02x does not begin a word; check that the file is G-code",
                  static_cast<unsigned>(static_cast<unsigned char>(c)));
  return Error{text};
}

// Reads the number at `at` and moves `at` past it.
Result<double> read_number(const std::string& code, size_t& at, char letter) {
  size_t end = at;
  bool negative = false;
  if (end < code.size() && (code[end] == '+' || code[end] == '-')) negative = code[end++] == '-';
  const size_t first = end;
  int digits = 0, points = 0;
  for (; end < code.size() && (is_digit(code[end]) || code[end] == '.'); end++)
    (code[end] == '.' ? points : digits)++;
  if (digits == 0) {
    if (end < code.size() && (code[end] == '#' || code[end] == '['))
      return unknown_character(code[end]);
    return Error{std::string(1, letter) + " has no number; write one after it"};
  }
  if (points > 1) return Error{std::string(1, letter) + " has a number with two points"};
  double value = 0;
  const auto [stop, error] = std::from_chars(code.data() + first, code.data() + end, value);
  if (error != std::errc() || stop != code.data() + end || !(value <= kMaxGcodeNumber))
    return Error{std::string(1, letter) + " has a number that is too large"};
  at = end;
  return negative ? -value : value;
}

// A program's number, as in O1000, has no effect. Other O-words control the flow.
Status check_o_word(const GcodeLine& line, const std::string& code, size_t at) {
  if (line.words.size() == 1 && at == code.size()) return Ok{};
  return Error{"an O-word needs LinuxCNC's interpreter; " + need_rs274()};
}

}  // namespace

const GcodeWord* GcodeLine::find(char letter) const {
  for (const GcodeWord& word : words)
    if (word.letter == letter) return &word;
  return nullptr;
}

std::string need_rs274() {
  return "install the Debian package linuxcnc-uspace, run 'rs274 -g PROGRAM > PROGRAM.canon' and "
         "mill PROGRAM.canon";
}

std::string word_text(char letter, double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%c%.10g", letter, value);
  return text;
}

Result<GcodeLine> parse_gcode(std::string_view text) {
  if (text.size() > kMaxGcodeLine)
    return Error{"the line has more than " + std::to_string(kMaxGcodeLine) +
                 " characters; check that the file is G-code"};
  GcodeLine line;
  std::string code;
  // The text of an optional line is not checked, because a controller skips the whole line.
  const size_t first = text.find_first_not_of(" \t\r");
  if (first != std::string_view::npos && text[first] == '/') {
    line.kind = GcodeLineKind::deleted;
    return line;
  }
  if (const Status ok = Splitter(text).run(code, line.comments); !ok) return Error{ok.error()};
  if (code == "%") {
    line.kind = GcodeLineKind::percent;
    return line;
  }
  for (size_t at = 0; at < code.size();) {
    const char letter = code[at];
    if (letter < 'A' || letter > 'Z') return unknown_character(letter);
    at++;
    if (letter == 'O' && (at == code.size() || !is_digit(code[at])))
      return Error{"an O-word needs LinuxCNC's interpreter; " + need_rs274()};
    const Result<double> value = read_number(code, at, letter);
    if (!value) return Error{value.error()};
    line.words.push_back({letter, value.value()});
    if (letter == 'O')
      if (const Status ok = check_o_word(line, code, at); !ok) return Error{ok.error()};
  }
  return line;
}

}  // namespace kibori
