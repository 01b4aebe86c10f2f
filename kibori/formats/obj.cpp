// SPDX-License-Identifier: MIT
#include <kibori/formats/obj.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <initializer_list>
#include <optional>

#include <kibori/base/tolerances.h>
#include <kibori/formats/polygons.h>
#include <kibori/formats/text.h>

namespace kibori {
namespace {

bool is_any_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}
// Statements with numbers. A backslash continues their line.
bool is_numbers(std::string_view keyword) {
  return is_any_of(keyword,
                   {"v",    "vt",   "vn",  "vp",    "f",    "fo",   "l",  "p",   "curv", "surf",
                    "parm", "trim", "con", "curv2", "hole", "scrv", "sp", "deg", "bmat", "step"});
}
// Statements that do not change the shape.
bool is_harmless(std::string_view keyword) {
  return is_any_of(
      keyword, {"vt",     "vn",     "vp",     "g",     "o",          "s",        "mg",   "usemtl",
                "mtllib", "usemap", "maplib", "bevel", "c_interp",   "d_interp", "lod",  "end",
                "cstype", "deg",    "bmat",   "step",  "parm",       "trim",     "hole", "scrv",
                "sp",     "con",    "ctech",  "stech", "shadow_obj", "trace_obj"});
}

class ObjParser {
 public:
  ObjParser(std::string_view text, const std::string& name, std::vector<std::string>* notes)
      : lines_(without_bom(text)), name_(name), notes_(notes) {}

  Result<TriangleMesh> run() {
    std::string_view line;
    while (lines_.next(line)) {
      line_ = lines_.number();
      if (const Status read = statement(line); !read) return Error{read.error()};
    }
    line_ = last_line_;
    if (last_ > mesh_.vertices.size()) return no_vertex(std::to_string(last_));
    if (mesh_.triangles.empty()) return nothing();
    polygons_.finish(mesh_);
    round_to_float(mesh_);
    if (no_area_) note("its points, lines and faces of fewer than three corners are left out");
    if (free_forms_)
      note("its free-form curves and surfaces are left out; export them as polygons");
    if (weights_) note("the weights of its vertices (their fourth number) are ignored");
    return std::move(mesh_);
  }

 private:
  Error wrong(const std::string& what) const {
    return Error{sanitize_message(name_ + ":" + std::to_string(line_) + ": " + what)};
  }
  void note(const std::string& what) {
    if (notes_) notes_->push_back(sanitize_message(name_ + ": " + what));
  }
  Error no_vertex(const std::string& index) const {
    return wrong("a face refers to vertex " + index + ", but the number of vertices is " +
                 std::to_string(mesh_.vertices.size()) + "; export it again");
  }
  Error nothing() const {
    if (mesh_.vertices.empty())
      return Error{
          name_ +
          ": has no vertex ('v' and three numbers) and no face; check that it is an OBJ file"};
    if (free_forms_)
      return Error{name_ +
                   ": has no triangles, only free-form curves or surfaces; export it as polygons"};
    return Error{name_ + ": has no triangles, only points or lines (" +
                 std::to_string(mesh_.vertices.size()) +
                 " vertices, no 'f' with three corners); export it with faces"};
  }

  Status statement(std::string_view line) {
    if (!take(line)) return Ok{};
    std::string_view rest = line;
    const std::string_view keyword = take_word(rest);
    if (keyword.empty()) return Ok{};
    std::string joined;
    if (is_numbers(keyword) && is_continued(rest)) {
      joined = continued(rest);
      rest = joined;
    }
    if (keyword == "v") return vertex(rest);
    if (keyword == "f" || keyword == "fo") return face(rest);
    if (keyword == "l" || keyword == "p") {
      no_area_ = true;
    } else if (is_any_of(keyword, {"curv", "curv2", "surf"})) {
      free_forms_ = true;
    } else if (keyword == "call" || keyword == "csh") {
      note("line " + std::to_string(line_) +
           " refers to another file or a command, which is ignored");
    } else if (!is_harmless(keyword) && !odd_) {
      odd_ = true;  // one note is enough
      note("line " + std::to_string(line_) + " begins with " + in_quotes(keyword) +
           ", which is not a statement of OBJ files; such lines are ignored");
    }
    return Ok{};
  }

  // Removes the comment and the spaces after the statement. Returns false if the line is then
  // empty.
  static bool take(std::string_view& line) {
    line = without_comment(line);
    while (!line.empty() && is_space(line.back())) line.remove_suffix(1);
    return !line.empty();
  }
  static bool is_continued(std::string_view line) { return line.ends_with('\\'); }
  // Joins the rest of a statement with the lines that continue it.
  std::string continued(std::string_view first) {
    std::string all(first.substr(0, first.size() - 1));
    std::string_view line;
    while (lines_.next(line)) {
      take(line);
      const bool more = is_continued(line);
      if (more) line.remove_suffix(1);
      all.append(" ").append(line);
      if (!more) break;
    }
    return all;
  }

  // v x y z [w], or [r g b] or [r g b a] instead of the weight.
  Status vertex(std::string_view rest) {
    Vec3 point = Vec3::Zero();
    int count = 0;
    double weight = 1;
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest), count++) {
      const std::optional<double> value = parse_number(word);
      if (!value) return wrong("expected a number, found " + in_quotes(word) + "; export it again");
      if (count < 3)
        point[count] = *value;
      else
        weight = *value;
    }
    if (count < 3)
      return wrong("a vertex has " + std::to_string(count) + " coordinates instead of three");
    weights_ = weights_ || (count == 4 && weight != 1);
    if (mesh_.vertices.size() >= 3 * kMaxImportTriangles)
      return wrong("has more than 300 million vertices; export fewer");
    mesh_.vertices.push_back(point);
    return Ok{};
  }

  // f v, v/vt, v//vn or v/vt/vn. Only the first number of each is used.
  Status face(std::string_view rest) {
    corners_.clear();
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
      const Result<uint32_t> corner = corner_of(word);
      if (!corner) return Error{corner.error()};
      corners_.push_back(corner.value());
    }
    no_area_ = no_area_ || corners_.size() < 3;
    polygons_.add(mesh_, corners_);
    if (mesh_.triangles.size() > kMaxImportTriangles)
      return wrong("has more than 100 million triangles; export fewer");
    return Ok{};
  }
  Result<uint32_t> corner_of(std::string_view word) {
    int64_t index = 0;
    const char* const end = word.data() + word.size();
    const auto [after, error] = std::from_chars(word.data(), end, index);
    const bool others = std::all_of(
        after, end, [](char c) { return c == '/' || c == '-' || (c >= '0' && c <= '9'); });
    const bool number = error == std::errc() && others && (after == end || *after == '/') &&
                        std::count(after, end, '/') <= 2;
    if (!number)
      return wrong("expected the number of a vertex, found " + in_quotes(word) +
                   "; export it again");
    const auto known = static_cast<int64_t>(mesh_.vertices.size());
    if (index == 0) return wrong("a face refers to vertex 0, but vertices are counted from 1");
    if (index < -known || index > static_cast<int64_t>(3 * kMaxImportTriangles))
      return no_vertex(std::to_string(index));
    // The vertex may come later in the file.
    if (index > known && static_cast<uint64_t>(index) > last_) {
      last_ = static_cast<uint64_t>(index);
      last_line_ = line_;
    }
    return static_cast<uint32_t>(index > 0 ? index - 1 : known + index);
  }

  Lines lines_;
  const std::string& name_;
  std::vector<std::string>* notes_;
  int line_ = 0;
  TriangleMesh mesh_;
  Polygons polygons_;
  std::vector<uint32_t> corners_;  // of one face
  uint64_t last_ = 0;              // largest index of a vertex that a face used before it was read
  int last_line_ = 0;              // line of that face
  bool no_area_ = false, free_forms_ = false, weights_ = false, odd_ = false;
};

}  // namespace

Result<TriangleMesh> parse_obj(std::string_view text, const std::string& name,
                               std::vector<std::string>* notes) {
  if (is_utf16(text)) return Error{name + ": is UTF-16 text; save it as UTF-8"};
  return ObjParser(text, name, notes).run();
}

}  // namespace kibori
