// SPDX-License-Identifier: MIT
#include <kibori/formats/off.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include <kibori/base/tolerances.h>
#include <kibori/formats/polygons.h>
#include <kibori/formats/text.h>

namespace kibori {
namespace {

// The data of each vertex, as the first word of the file announces it.
struct OffKind {
  bool texture = false, color = false, normal = false, weight = false, dimension = false;

  // How many numbers a vertex has, for a file without one line per vertex.
  int numbers() const { return 3 + weight + 3 * normal + 4 * color + 2 * texture; }
};

// Parses [ST][C][N][4][n]OFF; nullopt for any other word.
std::optional<OffKind> kind_of(std::string_view word) {
  OffKind kind;
  const auto take = [&](std::string_view prefix) {
    if (!word.starts_with(prefix)) return false;
    word.remove_prefix(prefix.size());
    return true;
  };
  kind.texture = take("ST");
  kind.color = take("C");
  kind.normal = take("N");
  kind.weight = take("4");
  kind.dimension = take("n");
  return word == "OFF" ? std::optional(kind) : std::nullopt;
}

class OffParser {
 public:
  OffParser(std::string_view text, const std::string& name, std::vector<std::string>* notes)
      : text_(without_bom(text)), lines_(text_), name_(name), notes_(notes) {}

  Result<TriangleMesh> run() {
    if (const Status read = header(); !read) return Error{read.error()};
    lines_left_ = count_lines();
    if (const Status read = vertices(); !read) return Error{read.error()};
    if (const Status read = faces(); !read) return Error{read.error()};
    if (more()) {
      if (!line_each_)
        return wrong(
            "has more numbers than its counts of vertices and faces need; export it again");
      if (notes_)
        notes_->push_back(name_ + ":" + std::to_string(line_) +
                          ": the text after the last face is ignored");
    }
    polygons_.finish(mesh_);
    round_to_float(mesh_);
    return std::move(mesh_);
  }

 private:
  Error wrong(const std::string& what) const {
    return Error{sanitize_message(name_ + ":" + std::to_string(line_) + ": " + what)};
  }

  // --- lines without comments, and the words of the current line

  static bool is_empty(std::string_view words) { return std::ranges::all_of(words, is_space); }
  uint64_t count_lines() const {
    Lines rest = lines_;
    std::string_view line;
    uint64_t count = 0;
    while (rest.next(line)) count += !is_empty(without_comment(line));
    return count;
  }
  // Moves to the next line with words, unless the current line has words left. Returns false at the
  // end of the file.
  bool more() {
    while (is_empty(words_)) {
      std::string_view line;
      if (!lines_.next(line)) return false;
      words_ = without_comment(line);
      line_ = lines_.number();
      if (lines_left_ > 0 && !is_empty(words_)) lines_left_--;
    }
    return true;
  }
  std::string_view next() {
    more();
    return take_word(words_);
  }

  // --- parts of the file

  Status header() {
    if (!more()) return Error{name_ + ": is empty; export it again"};
    std::string_view rest = words_;
    const std::string_view word = take_word(rest);
    OffKind kind;
    if (const std::optional<OffKind> named = kind_of(word)) {
      kind = *named;
      words_ = rest;
      if (is_empty(words_)) more();
      if (std::string_view(words_).find("BINARY") != std::string_view::npos)
        return wrong("binary OFF files are not read; save it as text, or as PLY");
    } else if (!parse_number(word)) {
      return wrong("the file begins with " + in_quotes(word) +
                   " instead of 'OFF'; check that it is an OFF file");
    }
    kind_ = kind;
    if (kind.dimension) {
      const Result<uint64_t> dimension = count("the dimension");
      if (!dimension) return Error{dimension.error()};
      if (dimension.value() != 3)
        return wrong("has vertices with " + std::to_string(dimension.value()) +
                     " dimensions; export it with three");
    }
    const Result<uint64_t> vertices = count("the number of vertices"),
                           faces = vertices ? count("the number of faces") : vertices;
    if (!faces) return Error{faces.error()};
    vertex_count_ = vertices.value();
    face_count_ = faces.value();
    // Every number needs at least two bytes, including its space.
    if (vertex_count_ > text_.size() / 6 || face_count_ > text_.size() / 2)
      return wrong("announces more vertices or faces than fit into the file; export it again");
    if (vertex_count_ > 3 * kMaxImportTriangles)
      return wrong("has more than 300 million vertices; export fewer");
    if (!is_empty(words_)) take_word(words_);  // skips the number of edges
    return Ok{};
  }
  Result<uint64_t> count(const std::string& what) {
    const std::string_view word = next();
    const std::optional<double> value = parse_number(word);
    if (!value || *value < 0 || *value != std::floor(*value))
      return wrong("expected " + what + ", found " + in_quotes(word) + "; export it again");
    return *value > 1e15 ? uint64_t{1} << 50 : static_cast<uint64_t>(*value);
  }

  Status vertices() {
    line_each_ = lines_left_ >= vertex_count_ + face_count_;
    mesh_.vertices.reserve(vertex_count_);
    for (uint64_t i = 0; i < vertex_count_; i++) {
      if (!more()) return Error{name_ + ": ends in the middle of its vertices; export it again"};
      double number[4] = {0, 0, 0, 1};
      const int total = line_each_ ? 3 + kind_.weight : kind_.numbers();
      for (int k = 0; k < total; k++) {
        const std::string_view word = line_each_ ? take_word(words_) : next();
        if (word.empty() && !line_each_)
          return Error{name_ + ": ends in the middle of its vertices; export it again"};
        const std::optional<double> value = parse_number(word);
        if (!value)
          return wrong("expected a coordinate, found " + in_quotes(word) + "; export it again");
        if (k < 3 + kind_.weight) number[k] = *value;
      }
      if (line_each_) words_ = {};
      mesh_.vertices.push_back(Vec3(number[0], number[1], number[2]) / number[3]);
      if (!mesh_.vertices.back().allFinite())
        return wrong("a vertex has a coordinate that is not a finite number; export it again");
    }
    return Ok{};
  }

  Status faces() {
    const bool line_each = lines_left_ >= face_count_;
    std::vector<uint32_t> corners;
    for (uint64_t i = 0; i < face_count_; i++) {
      if (!more()) return Error{name_ + ": ends in the middle of its faces; export it again"};
      const Result<uint64_t> count = this->count("the number of a face's corners");
      if (!count) return Error{count.error()};
      corners.clear();
      for (uint64_t k = 0; k < count.value(); k++) {
        if (line_each && is_empty(words_))
          return wrong("a face of " + std::to_string(count.value()) +
                       " corners lists fewer; export it again");
        const std::string_view word = next();
        if (word.empty())
          return Error{name_ + ": ends in the middle of its faces; export it again"};
        const std::optional<double> vertex = parse_number(word);
        if (!vertex || *vertex < 0 || *vertex != std::floor(*vertex) ||
            *vertex >= static_cast<double>(vertex_count_))
          return wrong("a face refers to a missing vertex (" + in_quotes(word) + ", of " +
                       std::to_string(vertex_count_) + " counted from 0); export it again");
        corners.push_back(static_cast<uint32_t>(*vertex));
      }
      if (line_each) words_ = {};  // skips the colour
      polygons_.add(mesh_, corners);
      if (mesh_.triangles.size() > kMaxImportTriangles)
        return wrong("has more than 100 million triangles; export fewer");
    }
    return Ok{};
  }

  const std::string_view text_;
  Lines lines_;
  const std::string& name_;
  std::vector<std::string>* notes_;
  std::string_view words_;   // rest of the current line
  uint64_t lines_left_ = 0;  // lines with words, after the current one
  int line_ = 0;
  bool line_each_ = true;  // each vertex and face has its own line
  OffKind kind_;
  uint64_t vertex_count_ = 0, face_count_ = 0;
  TriangleMesh mesh_;
  Polygons polygons_;
};

}  // namespace

Result<TriangleMesh> parse_off(std::string_view text, const std::string& name,
                               std::vector<std::string>* notes) {
  if (is_utf16(text)) return Error{name + ": is UTF-16 text; save it as UTF-8"};
  return OffParser(text, name, notes).run();
}

}  // namespace kibori
