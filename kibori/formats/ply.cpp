// SPDX-License-Identifier: MIT
#include <kibori/formats/ply.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <kibori/base/tolerances.h>
#include <kibori/formats/polygons.h>
#include <kibori/formats/text.h>

namespace kibori {
namespace {

enum class Form { ascii, little_endian, big_endian };
enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

constexpr std::array<size_t, 8> kBytes = {1, 1, 2, 2, 4, 4, 4, 8};
constexpr double kRestart = -1,
                 kUnsignedRestart = 4294967295;  // -1 in a list of unsigned 32-bit numbers

size_t bytes_of(Type type) { return kBytes[static_cast<size_t>(type)]; }

std::optional<Type> type_named(std::string_view word) {
  constexpr std::array<std::string_view, 8> kOld = {"char", "uchar", "short", "ushort",
                                                    "int",  "uint",  "float", "double"};
  constexpr std::array<std::string_view, 8> kNew = {"int8",  "uint8",  "int16",   "uint16",
                                                    "int32", "uint32", "float32", "float64"};
  for (size_t i = 0; i < kBytes.size(); i++)
    if (word == kOld[i] || word == kNew[i]) return static_cast<Type>(i);
  return std::nullopt;
}

struct Property {
  std::string name;
  Type type;                  // of the value, or of a list's items
  std::optional<Type> count;  // of a list: the type of its length
};
struct Element {
  std::string name;
  uint64_t rows = 0;
  std::vector<Property> properties;

  // Index of the first property with one of the names; npos if there is none.
  size_t find(bool list, std::initializer_list<std::string_view> names) const {
    for (size_t i = 0; i < properties.size(); i++)
      if (properties[i].count.has_value() == list &&
          std::ranges::count(names, properties[i].name) > 0)
        return i;
    return std::string::npos;
  }
};
struct PlyHeader {
  Form form = Form::ascii;
  std::vector<Element> elements;
  size_t bytes = 0;  // including the line end of its last line
  int lines = 0;
};

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::string_view word = take_word(line); !word.empty(); word = take_word(line))
    words.push_back(word);
  return words;
}

// True if the first line of the header ends with CR alone. Then all lines of the header do, and an
// LF after the last CR is the first byte of binary data.
bool ends_with_cr(std::string_view text) {
  const size_t end = text.find_first_of("\r\n");
  return end != std::string_view::npos && text[end] == '\r' && text.substr(end, 2) != "\r\n";
}

Result<PlyHeader> parse_header(std::string_view text, const std::string& name) {
  PlyHeader header;
  bool form_given = false;
  const char line_end = ends_with_cr(text) ? '\r' : '\n';
  const auto wrong = [&](const std::string& what) {
    return Error{sanitize_message(name + ":" + std::to_string(header.lines) + ": " + what)};
  };
  while (header.bytes < text.size()) {
    const size_t end = std::min(text.find(line_end, header.bytes), text.size());
    std::string_view line = text.substr(header.bytes, end - header.bytes);
    if (line.ends_with('\r')) line.remove_suffix(1);
    header.bytes = std::min(end + 1, text.size());
    header.lines++;
    const std::vector<std::string_view> words = words_of(line);
    if (header.lines == 1) {
      if (words.size() != 1 || words[0] != "ply")
        return wrong("the file does not begin with 'ply'; check that it is a PLY file");
    } else if (words.empty() || words[0] == "comment" || words[0] == "obj_info") {
      continue;
    } else if (words[0] == "end_header") {
      if (!form_given) return wrong("the header has no format (ascii or binary)");
      return header;
    } else if (words[0] == "format" && words.size() >= 2) {
      if (words[1] != "ascii" && words[1] != "binary_little_endian" &&
          words[1] != "binary_big_endian")
        return wrong("unknown format " + in_quotes(words[1]));
      header.form = words[1] == "ascii"                  ? Form::ascii
                    : words[1] == "binary_little_endian" ? Form::little_endian
                                                         : Form::big_endian;
      form_given = true;
    } else if (words[0] == "element" && words.size() == 3) {
      uint64_t rows = 0;
      const auto [rest, error] =
          std::from_chars(words[2].data(), words[2].data() + words[2].size(), rows);
      if (error != std::errc() || rest != words[2].data() + words[2].size())
        return wrong("invalid number " + in_quotes(words[2]) + " of element " +
                     in_quotes(words[1]));
      header.elements.push_back({std::string(words[1]), rows, {}});
    } else if (words[0] == "property" && !header.elements.empty() &&
               (words.size() == 3 || (words.size() == 5 && words[1] == "list"))) {
      const bool list = words.size() == 5;
      const std::optional<Type> type = type_named(words[list ? 3 : 1]),
                                count = list ? type_named(words[2]) : std::nullopt;
      if (!type || (list && !count))
        return wrong("unknown type " + in_quotes(words[list && !count ? 2 : list ? 3 : 1]));
      header.elements.back().properties.push_back({std::string(words.back()), *type, count});
    } else {
      return wrong("the header has an unknown line: " + in_quotes(line));
    }
  }
  return Error{name + ": its header has no end (end_header); export it again"};
}

// Reads the numbers after the header, one by one.
class Numbers {
 public:
  Numbers(std::span<const char> bytes, const PlyHeader& header)
      : at_(bytes.data() + header.bytes),
        end_(bytes.data() + bytes.size()),
        form_(header.form),
        line_(header.lines + 1) {}

  // Minimum number of bytes of a number. An ASCII file needs a space before every number except the
  // first.
  size_t min_bytes(Type type) const { return form_ == Form::ascii ? 2 : bytes_of(type); }
  size_t room() const { return static_cast<size_t>(end_ - at_) + (form_ == Form::ascii ? 1 : 0); }
  int line() const { return form_ == Form::ascii ? line_ : 0; }  // 0 in binary files
  const std::string& problem() const { return problem_; }

  // Reads the next number. Returns false if there is none; problem() then describes what was found.
  bool next(Type type, double& value) {
    if (form_ == Form::ascii) {
      const std::string_view word = next_word();
      if (word.empty()) return ended();
      if (const std::optional<double> number = parse_number(word)) {
        value = *number;
        if (type == Type::float32) value = static_cast<double>(static_cast<float>(value));
        return true;
      }
      problem_ = "expected a number, found " + in_quotes(word);
      return false;
    }
    const size_t size = bytes_of(type);
    if (static_cast<size_t>(end_ - at_) < size) return ended();
    std::array<char, 8> raw{};
    std::copy_n(at_, size, raw.data());
    at_ += size;
    if (form_ == Form::big_endian)
      std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    const auto as = [&](auto number) {
      std::memcpy(&number, raw.data(), sizeof number);
      return static_cast<double>(number);
    };
    switch (type) {
      case Type::int8:
        value = as(int8_t{});
        break;
      case Type::uint8:
        value = as(uint8_t{});
        break;
      case Type::int16:
        value = as(int16_t{});
        break;
      case Type::uint16:
        value = as(uint16_t{});
        break;
      case Type::int32:
        value = as(int32_t{});
        break;
      case Type::uint32:
        value = as(uint32_t{});
        break;
      case Type::float32:
        value = as(float{});
        break;
      case Type::float64:
        value = as(double{});
        break;
    }
    return true;
  }
  // Ends a row. In an ASCII file, this skips the rest of the line, because each row begins on a new
  // line. Returns true if the rest contains words, which belong to no property of the header.
  bool end_row() {
    if (form_ != Form::ascii) return false;
    const char* const begin = at_;
    while (at_ != end_ && !is_line_end(*at_)) at_++;
    return !std::all_of(begin, at_, is_space);
  }
  // True if there is data after the last row.
  bool more() {
    if (form_ != Form::ascii) return at_ != end_;
    return !next_word().empty();
  }

  // Skips a number. In an ASCII file, it may be any word.
  bool skip(Type type) {
    if (form_ == Form::ascii) return !next_word().empty() || ended();
    if (static_cast<size_t>(end_ - at_) < bytes_of(type)) return ended();
    at_ += bytes_of(type);
    return true;
  }

 private:
  static_assert(std::endian::native == std::endian::little);
  bool ended() {
    problem_ = "the file ends in the middle; export it again";
    return false;
  }
  std::string_view next_word() {
    for (; at_ != end_ && is_space(*at_); at_++)
      if (*at_ == '\n' || (*at_ == '\r' && (at_ + 1 == end_ || at_[1] != '\n'))) line_++;
    const char* begin = at_;
    while (at_ != end_ && !is_space(*at_)) at_++;
    return {begin, static_cast<size_t>(at_ - begin)};
  }

  const char* at_;
  const char* end_;
  Form form_;
  int line_;
  std::string problem_;
};

class Parser {
 public:
  Parser(std::span<const char> bytes, const PlyHeader& header, const std::string& name,
         std::vector<std::string>* notes)
      : header_(header), name_(name), notes_(notes), numbers_(bytes, header) {}

  Result<TriangleMesh> run() {
    const auto named = [&](const char* what) {
      return std::ranges::count(header_.elements, what, &Element::name);
    };
    if (named("vertex") != 1)
      return Error{name_ + ": its header has element 'vertex' " + std::to_string(named("vertex")) +
                   " times instead of once"};
    vertices_ = std::ranges::find(header_.elements, "vertex", &Element::name)->rows;
    if (vertices_ > 3 * kMaxImportTriangles)
      return Error{name_ + ": has more than 300 million vertices; export fewer"};
    for (const Element& element : header_.elements)
      if (const Status read = read_element(element); !read) return Error{read.error()};
    if (!has_faces_)
      return Error{name_ + ": has only points (" + std::to_string(vertices_) +
                   ") and no faces; convert them to a mesh first"};
    if (numbers_.more()) note("the data after its last element is ignored");
    if (left_over_) note("numbers without a property in its header are ignored");
    polygons_.finish(mesh_);
    return std::move(mesh_);
  }

 private:
  void note(const std::string& what) {
    if (notes_) notes_->push_back(name_ + ": " + what);
  }

  // The current place, for messages.
  std::string place(const Element& element, uint64_t row) const {
    return (numbers_.line() ? name_ + ":" + std::to_string(numbers_.line()) : name_) + ": " +
           sanitize_message(in_quotes(element.name)) + " " + std::to_string(row + 1);
  }
  Error stopped(const Element& element, uint64_t row) const {
    return Error{sanitize_message(place(element, row) + ": " + numbers_.problem())};
  }

  Status read_element(const Element& element) {
    const bool vertex = element.name == "vertex", strip = element.name == "tristrips",
               face = element.name == "face";
    std::array<size_t, 3> xyz{};
    for (size_t i = 0; vertex && i < 3; i++) {
      const std::string_view letter = std::string_view("xyz").substr(i, 1);
      xyz[i] = element.find(false, {letter});
      if (xyz[i] == std::string::npos)
        return Error{name_ + ": element 'vertex' has no property " + in_quotes(letter)};
    }
    const size_t corners =
        strip || face ? element.find(true, {"vertex_indices", "vertex_index"}) : std::string::npos;
    if (strip && corners == std::string::npos)
      return Error{name_ + ": element 'tristrips' has no list 'vertex_indices'"};
    if (face && corners == std::string::npos && element.rows > 0)
      return Error{name_ + ": element 'face' has no list 'vertex_indices'"};
    has_faces_ = has_faces_ || ((face || strip) && element.rows > 0);
    if (element.properties.empty()) return Ok{};  // its rows are empty
    size_t min = 0;
    for (const Property& p : element.properties)
      min += numbers_.min_bytes(p.count.value_or(p.type));
    if (element.rows > numbers_.room() / min)
      return Error{sanitize_message(name_ + ": is too short for the " +
                                    std::to_string(element.rows) + " of element " +
                                    in_quotes(element.name) + " in its header; export it again")};
    if (vertex) mesh_.vertices.reserve(static_cast<size_t>(element.rows));

    std::vector<double> list;
    for (uint64_t row = 0; row < element.rows; row++) {
      Vec3 point = Vec3::Zero();
      for (size_t p = 0; p < element.properties.size(); p++) {
        const Property& property = element.properties[p];
        if (property.count) {
          list.clear();
          if (Status read = read_list(element, row, property, p == corners ? &list : nullptr);
              !read)
            return read;
          if (p != corners) continue;
          if (Status added = strip ? add_strip(element, row, list) : add_face(element, row, list);
              !added)
            return added;
          continue;
        }
        const auto axis = vertex ? std::ranges::find(xyz, p) : xyz.end();
        if (axis == xyz.end() ? !numbers_.skip(property.type)
                              : !numbers_.next(property.type, point[axis - xyz.begin()]))
          return stopped(element, row);
      }
      left_over_ = numbers_.end_row() || left_over_;
      if (!vertex) continue;
      if (!point.allFinite())
        return Error{place(element, row) + ": has a coordinate that is not a finite number"};
      mesh_.vertices.push_back(point);
    }
    return Ok{};
  }

  // `into`: null if the items are not needed.
  Status read_list(const Element& element, uint64_t row, const Property& property,
                   std::vector<double>* into) {
    double count = 0;
    if (!numbers_.next(*property.count, count)) return stopped(element, row);
    if (!(count >= 0) || count != std::floor(count))
      return Error{place(element, row) + ": has a list of invalid length; export it again"};
    const size_t room = numbers_.room() / numbers_.min_bytes(property.type);
    if (count > static_cast<double>(room))
      return Error{place(element, row) + ": has a list that exceeds the file; export it again"};
    if (into) into->reserve(static_cast<size_t>(count));
    for (double i = 0; i < count; i++) {
      double value = 0;
      if (into ? !numbers_.next(property.type, value) : !numbers_.skip(property.type))
        return stopped(element, row);
      if (into) into->push_back(value);
    }
    return Ok{};
  }

  Error no_vertex(const Element& element, uint64_t row, double index) const {
    char text[48];
    std::snprintf(text, sizeof text, "%.12g", index);
    return Error{place(element, row) + ": refers to vertex " + text +
                 ", but the number of vertices is " + std::to_string(vertices_) +
                 ", counted from 0; export it again"};
  }
  bool there(double index) const {
    return index >= 0 && index < static_cast<double>(vertices_) && index == std::floor(index);
  }
  void add(double a, double b, double c) {
    mesh_.triangles.push_back(
        {static_cast<uint32_t>(a), static_cast<uint32_t>(b), static_cast<uint32_t>(c)});
  }

  Status add_strip(const Element& element, uint64_t row, const std::vector<double>& list) {
    size_t begin = 0;
    for (size_t i = 0; i < list.size(); i++) {
      if (list[i] == kRestart || list[i] == kUnsignedRestart) {
        begin = i + 1;
        continue;
      }
      if (!there(list[i])) return no_vertex(element, row, list[i]);
      if (i < begin + 2) continue;
      const bool turned = (i - begin) % 2 == 1;
      const double a = list[turned ? i - 1 : i - 2], b = list[turned ? i - 2 : i - 1], c = list[i];
      // A degenerate triangle only connects to the next one.
      if (a != b && b != c && c != a) add(a, b, c);
    }
    if (mesh_.triangles.size() > kMaxImportTriangles) return too_many();
    return Ok{};
  }

  Status add_face(const Element& element, uint64_t row, const std::vector<double>& list) {
    corners_.clear();
    for (const double index : list) {
      if (!there(index)) return no_vertex(element, row, index);
      corners_.push_back(static_cast<uint32_t>(index));
    }
    polygons_.add(mesh_, corners_);
    if (mesh_.triangles.size() > kMaxImportTriangles) return too_many();
    return Ok{};
  }
  Error too_many() const {
    return Error{name_ + ": has more than 100 million triangles; export fewer"};
  }

  const PlyHeader& header_;
  const std::string& name_;
  std::vector<std::string>* notes_;
  Numbers numbers_;
  uint64_t vertices_ = 0;
  TriangleMesh mesh_;
  Polygons polygons_;
  std::vector<uint32_t> corners_;  // of one face
  bool has_faces_ = false, left_over_ = false;
};

}  // namespace

Result<TriangleMesh> parse_ply(std::span<const char> bytes, const std::string& name,
                               std::vector<std::string>* notes) {
  const std::string_view text = without_bom({bytes.data(), bytes.size()});
  bytes = bytes.last(text.size());
  const Result<PlyHeader> header = parse_header(text, name);
  if (!header) return Error{header.error()};
  return Parser(bytes, header.value(), name, notes).run();
}

}  // namespace kibori
