// SPDX-License-Identifier: MIT
#include <kibori/formats/stl.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include <kibori/formats/text.h>

namespace kibori {
namespace {

constexpr size_t kStlHeader = 84, kTriangle = 50, kCountAt = 80;

uint32_t little_endian(std::string_view bytes, size_t at, size_t size) {
  uint32_t value = 0;
  for (size_t i = 0; i < size; i++)
    value |= static_cast<uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return value;
}

void add_triangle(TriangleMesh& mesh, const Vec3 (&corner)[3]) {
  const auto first = static_cast<uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), corner, corner + 3);
  mesh.triangles.push_back({first, first + 1, first + 2});
}

// --- binary

// True if the attribute of each triangle is the length of further data, and the file ends exactly
// after the last of these.
bool has_payloads(std::string_view bytes, uint64_t count) {
  size_t at = kStlHeader;
  for (uint64_t i = 0; i < count; i++) {
    if (bytes.size() - at < kTriangle) return false;
    const size_t payload = little_endian(bytes, at + kTriangle - 2, 2);
    at += kTriangle;
    if (bytes.size() - at < payload) return false;
    at += payload;
  }
  return at == bytes.size();
}

Result<TriangleMesh> parse_binary(std::string_view bytes, const std::string& name,
                                  std::vector<std::string>* notes) {
  const uint64_t count = little_endian(bytes, kCountAt, 4);
  const uint64_t room = (bytes.size() - kStlHeader) / kTriangle,
                 end = kStlHeader + count * kTriangle;
  const std::string promise =
      name + ": byte 80 promises " + std::to_string(count) + " triangles, but the file ";
  if (end > bytes.size())
    return Error{promise + "holds " + std::to_string(room) + " (cut short?); export it again"};
  const bool payloads = end < bytes.size() && has_payloads(bytes, count);
  if (end < bytes.size() && !payloads) {
    if ((bytes.size() - kStlHeader) % kTriangle == 0)
      return Error{promise + "holds " + std::to_string(room) + "; export it again"};
    if (notes)
      notes->push_back(name + ": " + std::to_string(bytes.size() - end) +
                       " bytes after the last of " + std::to_string(count) +
                       " triangles are ignored");
  }
  TriangleMesh mesh;
  mesh.vertices.reserve(count * 3);
  mesh.triangles.reserve(count);
  size_t at = kStlHeader;
  for (uint64_t i = 0; i < count; i++) {
    Vec3 corner[3];
    for (size_t k = 0; k < 9; k++) {
      const size_t number_at = at + 12 + 4 * k;
      const float value = std::bit_cast<float>(little_endian(bytes, number_at, 4));
      if (!std::isfinite(value))
        return Error{name + ": byte " + std::to_string(number_at) +
                     " has a coordinate that is not a finite number; export it again"};
      corner[k / 3][static_cast<int>(k % 3)] = static_cast<double>(value);
    }
    add_triangle(mesh, corner);
    at += kTriangle + (payloads ? little_endian(bytes, at + kTriangle - 2, 2) : 0);
  }
  return mesh;
}

// --- ASCII

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// Compares a word with `expected`, which is in lower case. The case of the word does not matter.
bool is_word(std::string_view word, std::string_view expected) {
  return std::ranges::equal(word, expected, {}, lower);
}

// The text without the spaces before its first word.
std::string_view at_word(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  return text;
}

// True if a text begins with "facet normal" or "facet outer". No name of a solid begins like this.
bool begins_facet(std::string_view text) {
  if (!is_word(take_word(text), "facet")) return false;
  const std::string_view word = take_word(text);
  return is_word(word, "normal") || is_word(word, "outer");
}

// Position of `word` (in lower case) in a text; the text's end if it does not occur. The case of
// the text does not matter.
std::string_view::iterator find_word(std::string_view text, std::string_view word) {
  return std::search(text.begin(), text.end(), word.begin(), word.end(),
                     [](char a, char b) { return lower(a) == b; });
}

// True if a text has a facet, or the end of a solid without facets.
bool has_facet(std::string_view text) {
  for (std::string_view left = text;;) {
    left.remove_prefix(static_cast<size_t>(find_word(left, "facet") - left.begin()));
    if (left.empty()) break;
    if (begins_facet(left)) return true;
    left.remove_prefix(1);
  }
  return find_word(text, "endsolid") != text.end();
}

bool is_ascii(std::string_view bytes) {
  std::string_view text = at_word(without_bom(bytes));
  const std::string_view all = text, word = take_word(text);
  return (is_word(word, "solid") || is_word(word, "facet")) && has_facet(all);
}

bool is_printable(std::string_view bytes) {
  return std::ranges::all_of(
      bytes, [](char c) { return (c >= ' ' && c < 0x7f) || c == '\t' || c == '\n' || c == '\r'; });
}

class AsciiParser {
 public:
  AsciiParser(std::string_view text, const std::string& name, std::vector<std::string>* notes)
      : text_(without_bom(text)), name_(name), notes_(notes) {}

  Result<TriangleMesh> run() {
    for (std::string_view word = next(); !word.empty(); word = next()) {
      const Result<bool> read = statement(word);
      if (!read) return Error{read.error()};
      if (!read.value()) break;
    }
    if (corners_ != 0 || !ended_)
      return wrong("the file ends in the middle (no endsolid); export it again");
    round_to_float(mesh_);
    return std::move(mesh_);
  }

 private:
  Error wrong(const std::string& what) const {
    return Error{sanitize_message(name_ + ":" + std::to_string(line_) + ": " + what)};
  }

  // Reads the statement of a keyword. Returns false if the rest of the file is ignored.
  Result<bool> statement(std::string_view word) {
    const bool in_normal = std::exchange(in_normal_, false);
    if (is_word(word, "vertex")) {
      if (const Status read = vertex(); !read) return Error{read.error()};
    } else if (is_word(word, "endfacet")) {
      if (corners_ != 3)
        return wrong("a facet has " + std::to_string(corners_) + " vertices instead of three");
      add_triangle(mesh_, corner_);
      corners_ = 0;
    } else if (is_word(word, "facet")) {
      if (corners_ != 0) return wrong("a facet begins inside another");
      ended_ = false;
      in_normal_ = true;
    } else if (is_word(word, "endsolid") || is_word(word, "solid")) {
      ended_ = is_word(word, "endsolid");
      skip_name();
    } else if (!is_word(word, "outer") && !is_word(word, "loop") && !is_word(word, "endloop")) {
      if (in_normal) {
        in_normal_ = true;  // its numbers are not used; the corners give the direction
      } else if (ended_ && !has_facet(text_.substr(at_))) {
        if (notes_)
          notes_->push_back(sanitize_message(name_ + ":" + std::to_string(line_) +
                                             ": the text after endsolid is ignored"));
        return false;
      } else {
        return wrong("expected facet, vertex or endsolid, found " + in_quotes(word) +
                     "; export it again");
      }
    }
    return true;
  }

  Status vertex() {
    if (corners_ == 3) return wrong("a facet has more than three vertices; export triangles");
    for (int i = 0; i < 3; i++) {
      const std::string_view word = next();
      const std::optional<double> value = parse_number(word);
      if (!value)
        return wrong("expected a coordinate, found " + in_quotes(word) + "; export it again");
      corner_[corners_][i] = *value;
    }
    corners_++;
    return Ok{};
  }

  std::string_view next() {
    while (at_ < text_.size() && is_space(text_[at_])) {
      if (text_[at_] == '\n' || (text_[at_] == '\r' && text_.substr(at_, 2) != "\r\n")) line_++;
      at_++;
    }
    const size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_])) at_++;
    return text_.substr(begin, at_ - begin);
  }
  // Skips the name of a solid. It is the rest of the line, or ends before a facet or an endsolid in
  // the same line.
  void skip_name() {
    while (at_ < text_.size() && !is_line_end(text_[at_])) {
      const std::string_view rest = text_.substr(at_);
      if (is_space(rest.front())) {
        at_++;
        continue;
      }
      std::string_view after = rest;
      const std::string_view word = take_word(after);
      if (is_word(word, "endsolid") || begins_facet(rest)) return;
      at_ += word.size();
    }
  }

  const std::string_view text_;
  const std::string& name_;
  std::vector<std::string>* notes_;
  size_t at_ = 0;
  int line_ = 1;
  TriangleMesh mesh_;
  Vec3 corner_[3];
  int corners_ = 0;  // number of corners so far in the current facet
  bool ended_ = false, in_normal_ = false;
};

}  // namespace

Result<TriangleMesh> parse_stl(std::string_view bytes, const std::string& name,
                               std::vector<std::string>* notes) {
  const bool exact =
      bytes.size() >= kStlHeader &&
      bytes.size() == kStlHeader + uint64_t{little_endian(bytes, kCountAt, 4)} * kTriangle;
  if (!exact && is_ascii(bytes)) return AsciiParser(bytes, name, notes).run();
  if (!exact && is_utf16(bytes))
    return Error{name + ": is UTF-16 text; save it as plain text or as a binary STL file"};
  // If the header and the count of triangles are printable, the file is text. As a number, four
  // printable characters are more than 150 million.
  if (!exact && bytes.size() >= kStlHeader && is_printable(bytes.substr(0, kStlHeader)))
    return Error{name + ": is text, but has no 'solid' with facets; check that it is an STL file"};
  if (bytes.size() < kStlHeader)
    return Error{name + ": an STL file has at least 84 bytes, this one has " +
                 std::to_string(bytes.size()) + "; export it again"};
  return parse_binary(bytes, name, notes);
}

}  // namespace kibori
