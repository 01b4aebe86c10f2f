// SPDX-License-Identifier: MIT
#include <kibori/formats/mesh_file.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/base/tolerances.h>
#include <kibori/formats/import_helper.h>

namespace kibori {
namespace {

constexpr size_t kStlHeader = 84, kStlTriangle = 50;

uint32_t little_endian(const char* p) {
  const auto* b = reinterpret_cast<const unsigned char*>(p);
  return b[0] | static_cast<uint32_t>(b[1]) << 8 | static_cast<uint32_t>(b[2]) << 16 |
         static_cast<uint32_t>(b[3]) << 24;
}

void add_triangle(TriangleMesh& mesh, const Vec3 (&corner)[3]) {
  const auto first = static_cast<uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), corner, corner + 3);
  mesh.triangles.push_back({first, first + 1, first + 2});
}

Result<TriangleMesh> parse_binary_stl(const char* data, size_t size, const std::string& name) {
  const uint64_t count = little_endian(data + 80);
  const uint64_t there = (size - kStlHeader) / kStlTriangle;
  if (size != kStlHeader + count * kStlTriangle)
    return Error{name + ": byte 80 promises " + std::to_string(count) +
                 " triangles, but the file holds " + std::to_string(there) +
                 (there < count ? " (cut short?)" : "") + "; export it again"};
  TriangleMesh mesh;
  mesh.vertices.reserve(count * 3);
  mesh.triangles.reserve(count);
  for (uint64_t i = 0; i < count; i++) {
    const size_t at = kStlHeader + i * kStlTriangle + 12;
    Vec3 corner[3];
    for (size_t k = 0; k < 9; k++) {
      const float value = std::bit_cast<float>(little_endian(data + at + 4 * k));
      if (!std::isfinite(value))
        return Error{name + ": byte " + std::to_string(at + 4 * k) +
                     " holds a coordinate that is not a finite number"};
      corner[k / 3][static_cast<int>(k % 3)] = static_cast<double>(value);
    }
    add_triangle(mesh, corner);
  }
  return mesh;
}

// Words of an ASCII file with their line numbers.
class Words {
 public:
  Words(const char* data, size_t size) : at_(data), end_(data + size) {}
  std::string_view next() {
    while (at_ != end_ && std::isspace(static_cast<unsigned char>(*at_))) {
      if (*at_ == '\n') line_++;
      at_++;
    }
    const char* begin = at_;
    while (at_ != end_ && !std::isspace(static_cast<unsigned char>(*at_))) at_++;
    return {begin, static_cast<size_t>(at_ - begin)};
  }
  void skip_line() {
    while (at_ != end_ && *at_ != '\n') at_++;
  }
  int line() const { return line_; }

 private:
  const char* at_;
  const char* end_;
  int line_ = 1;
};

bool is_word(std::string_view word, std::string_view expected) {
  return std::equal(word.begin(), word.end(), expected.begin(), expected.end(), [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  });
}

Result<TriangleMesh> parse_ascii_stl(const char* data, size_t size, const std::string& name) {
  TriangleMesh mesh;
  Words words(data, size);
  words.next();  // solid
  words.skip_line();
  const auto wrong = [&](const std::string& what) {
    return Error{sanitize_message(name + ":" + std::to_string(words.line()) + ": " + what)};
  };
  Vec3 corner[3];
  int corners = 0;
  bool ended = false;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (is_word(word, "vertex")) {
      if (corners == 3) return wrong("a facet has more than three vertices");
      for (int i = 0; i < 3; i++) {
        const std::string_view number = words.next();
        const char* begin = number.data() + (number.starts_with('+') ? 1 : 0);
        double value = 0;
        const auto [end, error] = std::from_chars(begin, number.data() + number.size(), value);
        const auto single = static_cast<float>(value);  // as everyone writes them
        if (error != std::errc() || end != number.data() + number.size() || !std::isfinite(single))
          return wrong("expected a coordinate, found '" + std::string(number.substr(0, 20)) + "'");
        corner[corners][i] = static_cast<double>(single);
      }
      corners++;
    } else if (is_word(word, "endfacet")) {
      if (corners != 3)
        return wrong("a facet has " + std::to_string(corners) + " vertices instead of three");
      add_triangle(mesh, corner);
      corners = 0;
    } else if (is_word(word, "facet")) {
      if (corners != 0) return wrong("a facet begins inside another");
      words.skip_line();
    } else if (is_word(word, "endsolid")) {
      ended = true;
      words.skip_line();
    } else if (is_word(word, "solid")) {
      ended = false;
      words.skip_line();
    } else if (!is_word(word, "outer") && !is_word(word, "loop") && !is_word(word, "endloop")) {
      return wrong("expected facet, vertex or endsolid, found '" + std::string(word.substr(0, 20)) +
                   "'");
    }
  }
  if (corners != 0 || !ended)
    return wrong("the file ends in the middle (no endsolid); export it again");
  return mesh;
}

}  // namespace

Result<TriangleMesh> parse_stl(const char* data, size_t size, const std::string& name) {
  // Binary files may begin with "solid" too: the length decides, then the look of the first lines.
  const bool exact =
      size >= kStlHeader && size == kStlHeader + uint64_t{little_endian(data + 80)} * kStlTriangle;
  const std::string_view head(data, std::min<size_t>(size, 1024));
  const bool text = head.starts_with("solid") && head.find('\0') == std::string_view::npos &&
                    (head.find("facet") != std::string_view::npos ||
                     head.find("endsolid") != std::string_view::npos);
  if (!exact && text) return parse_ascii_stl(data, size, name);
  if (size < kStlHeader)
    return Error{name + ": an STL file has at least 84 bytes, this one has " +
                 std::to_string(size)};
  return parse_binary_stl(data, size, name);
}

Result<TriangleMesh> read_mesh(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return Error{path.string() + ": no such file"};
  if (!std::filesystem::is_regular_file(path, error))
    return Error{path.string() + ": is not a regular file but a folder, a pipe or a device"};
  Result<TriangleMesh> mesh = Error{};
  if (ending == ".stl") {
    const Result<std::vector<char>> bytes = read_file(path);
    if (!bytes) return Error{bytes.error()};
    mesh = parse_stl(bytes.value().data(), bytes.value().size(), path.string());
  } else if (is_one_of(kMeshesRead, ending)) {
    mesh = read_in_helper(path);
  } else {
    return Error{path.string() + ": meshes are read from " + list_of(kMeshesRead, ", ", " and ") +
                 " files"};
  }
  if (mesh)
    for (const Vec3& p : mesh.value().vertices)
      if (!(p.cwiseAbs().maxCoeff() <= kMaxCoordinate))
        return Error{path.string() + ": has coordinates beyond 10^12 mm; scale it down"};
  if (mesh && mesh.value().triangles.empty()) return Error{path.string() + ": holds no triangles"};
  return mesh;
}

}  // namespace kibori
