// SPDX-License-Identifier: MIT
// PLY files with triangle strips give the same triangles as files of faces, in every encoding. Also
// hostile files.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include <unistd.h>

#include <kibori/formats/mesh_file.h>
#include <kibori/formats/ply.h>

#include "tests/support.h"

namespace kibori::ply_tests {
namespace {

using test::Random;

enum class Form { ascii, little_endian, big_endian };
constexpr Form kForms[] = {Form::ascii, Form::little_endian, Form::big_endian};

// Writes a PLY file, number by number.
class Writer {
 public:
  explicit Writer(Form form) : form_(form) {
    line("ply");
    line(form == Form::ascii           ? "format ascii 1.0"
         : form == Form::little_endian ? "format binary_little_endian 1.0"
                                       : "format binary_big_endian 1.0");
    line("comment element tristrips 7");
  }
  void line(const std::string& text) { bytes_ += text + "\n"; }
  template <class T>
  void number(T value) {
    if (form_ == Form::ascii) {
      char text[40];
      std::snprintf(text, sizeof text, "%.17g ", static_cast<double>(value));
      bytes_ += text;
      return;
    }
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (form_ == Form::big_endian) std::reverse(raw, raw + sizeof value);
    bytes_.append(raw, sizeof value);
  }
  void end_row() {
    if (form_ == Form::ascii) bytes_ += "\n";
  }
  const std::string& bytes() const { return bytes_; }

 private:
  Form form_;
  std::string bytes_;
};

constexpr int kColumns = 9, kRows = 7;
int at(int i, int j) { return j * kColumns + i; }

std::vector<Vec3> grid() {
  std::vector<Vec3> points;
  for (int j = 0; j < kRows; j++)
    for (int i = 0; i < kColumns; i++)
      points.emplace_back(i + 0.1 * j, j, 0.125 * ((i * 5 + j * 3) % 7));
  return points;
}

// The cells of some rows, two triangles each, all of them facing down.
std::vector<std::array<int, 3>> faces(int from_row, int to_row) {
  std::vector<std::array<int, 3>> all;
  for (int j = from_row; j < to_row; j++)
    for (int i = 0; i + 1 < kColumns; i++) {
      all.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
      all.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  return all;
}

// The same cells as strips: one per row, randomly interrupted and restarted. If a piece begins with
// an odd triangle, its first vertex is repeated. A restart, or degenerate triangles, separate rows.
std::vector<int> strips(int from_row, int to_row, Random& random) {
  std::vector<int> list;
  for (int j = from_row; j < to_row; j++) {
    if (j > from_row && random.integer(0, 1)) {
      const int last = list.back();
      list.insert(list.end(), {last, at(0, j)});
    } else if (j > from_row) {
      list.push_back(-1);
      if (random.integer(0, 1)) list.push_back(-1);  // nothing between two restarts
    }
    const size_t begin = list.size();
    for (int k = 0; k < 2 * kColumns; k++) {
      list.push_back(at(k / 2, j + k % 2));
      // The next triangle begins with the last two vertices.
      if (list.size() > begin + 2 && k + 1 < 2 * kColumns && random.integer(0, 5) == 0) {
        const int before = at((k - 1) / 2, j + (k - 1) % 2), last = list.back();
        list.push_back(-1);
        if (k % 2 == 0) list.push_back(before);  // (k - 1) % 2 == 1: reversed
        list.insert(list.end(), {before, last});
      }
    }
  }
  return list;
}

// A file of the grid: rows [0, split) as faces and the others as strips, with many irrelevant
// elements.
template <class Float, class Index>
std::string file_of(Form form, int split, Random& random) {
  const auto points = grid();
  const auto some = faces(0, split);
  const std::string real = sizeof(Float) == 4 ? "float" : "float64",
                    index = std::is_signed_v<Index> ? "int" : "uint";
  const auto list = strips(split, kRows - 1, random);
  const size_t half = std::min<size_t>(
      list.size(),
      static_cast<size_t>(
          std::find(list.begin() + static_cast<std::ptrdiff_t>(list.size() / 2), list.end(), -1) -
          list.begin()));
  Writer file(form);
  const bool plain = split == kRows - 1;
  if (!plain) file.line("element camera 1\nproperty float fov\nproperty list uchar short pixels");
  file.line("element vertex " + std::to_string(points.size()));
  file.line("property uchar red\nproperty " + real + " x");
  if (!plain) file.line("property list uchar double weights");
  file.line("property " + real + " y\nproperty " + real + " z");
  if (split > 0) {
    file.line("element face " + std::to_string(some.size()));
    file.line(
        "property uchar flags\nproperty list uchar int vertex_indices\nproperty int material");
  }
  if (!plain)
    file.line("element tristrips 2\nproperty list int " + index +
              " vertex_indices\nelement empty 5\nelement tail 1\nproperty double end");
  file.line("end_header");
  if (!plain) {
    file.number(45.0f), file.number(uint8_t{2}), file.number(int16_t{-3}), file.number(int16_t{4});
    file.end_row();
  }
  for (const Vec3& p : points) {
    file.number(uint8_t{200}), file.number(static_cast<Float>(p.x()));
    if (!plain) file.number(uint8_t{1}), file.number(0.5);
    file.number(static_cast<Float>(p.y())), file.number(static_cast<Float>(p.z()));
    file.end_row();
  }
  for (const auto& f : some) {
    file.number(uint8_t{7}), file.number(uint8_t{3});
    for (const int i : f) file.number(i);
    file.number(-5), file.end_row();
  }
  for (const auto& [from, to] : {std::pair<size_t, size_t>{0, half}, {half, list.size()}}) {
    if (plain) break;
    file.number(static_cast<int>(to - from));
    for (size_t i = from; i < to; i++) file.number(static_cast<Index>(list[i]));
    file.end_row();
  }
  if (!plain) file.number(1.5), file.end_row();
  return file.bytes();
}

// Triangles by their corners, each starting with its smallest.
std::vector<std::array<std::array<double, 3>, 3>> triangles_of(const TriangleMesh& mesh) {
  std::vector<std::array<std::array<double, 3>, 3>> all;
  for (const auto& t : mesh.triangles) {
    std::array<std::array<double, 3>, 3> corners;
    for (size_t i = 0; i < 3; i++)
      for (int k = 0; k < 3; k++)
        corners[i][static_cast<size_t>(k)] =
            static_cast<double>(static_cast<float>(mesh.vertices[t[i]][k]));
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    all.push_back(corners);
  }
  std::sort(all.begin(), all.end());
  return all;
}

class PlyTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  // Reads it as any mesh, through the helper program.
  Result<TriangleMesh> read(const std::string& bytes) const {
    std::ofstream(folder_ / "a.ply", std::ios::binary) << bytes;
    return read_mesh(folder_ / "a.ply");
  }
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("kibori-ply-" + std::to_string(getpid()));
};

TEST_F(PlyTest, StripsAreTheTrianglesOfTheSameFaces) {
  Random random;
  const auto check = [&](const std::string& bytes, const std::string& what) {
    const auto mesh = read(bytes);
    ASSERT_TRUE(mesh.ok()) << what << ": " << mesh.error();
    TriangleMesh wanted;
    wanted.vertices = grid();
    for (const auto& f : faces(0, kRows - 1))
      wanted.triangles.push_back(
          {static_cast<uint32_t>(f[0]), static_cast<uint32_t>(f[1]), static_cast<uint32_t>(f[2])});
    EXPECT_EQ(triangles_of(mesh.value()), triangles_of(wanted)) << what << "; " << random.note();
  };
  for (const Form form : kForms)
    // Only faces (another reader), only strips, both.
    for (const int split : {kRows - 1, 0, 3}) {
      const std::string what = "form " + std::to_string(static_cast<int>(form)) + ", " +
                               std::to_string(split) + " rows as faces";
      check(file_of<float, int32_t>(form, split, random), what);
      check(file_of<double, int32_t>(form, split, random), what + ", double");
      check(file_of<float, uint32_t>(form, split, random), what + ", restart in a list of uint");
    }
}

TEST(Ply, OneStripAroundATetrahedronFacesOutwards) {
  const std::string head =
      "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty float x\r\nproperty float "
      "y\r\nproperty float "
      "z\r\n"
      "element tristrips 1\r\nproperty list int int vertex_index\r\nend_header\r\n"
      "0 0 0\r\n0 1 0\r\n1 0 0\r\n0 0 1\r\n";
  const std::string file = head + "6 0 1 2 3 0 1\r\n";
  const auto mesh = parse_ply(file, "a");
  ASSERT_TRUE(mesh.ok()) << mesh.error();
  ASSERT_EQ(mesh.value().triangles.size(), 4u);
  double volume = 0;
  for (const auto& t : mesh.value().triangles) {
    const auto& v = mesh.value().vertices;
    volume += v[t[0]].dot(v[t[1]].cross(v[t[2]])) / 6;
  }
  EXPECT_NEAR(volume, 1.0 / 6, 1e-15);
}

TEST(Ply, PolygonsNextToStripsBecomeFans) {
  const auto mesh =
      parse_ply(std::string("ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty "
                            "float y\nproperty float z\n"
                            "element empty 99999999999999\nelement face 3\nproperty list uchar int "
                            "vertex_index\nelement "
                            "tristrips 1\n"
                            "property list int int vertex_indices\nend_header\n"
                            "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n5 0 1 2 3 4\n2 0 1\n0\n0\n"),
                "a");
  ASSERT_TRUE(mesh.ok()) << mesh.error();
  EXPECT_EQ(mesh.value().triangles,
            (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST_F(PlyTest, BadFilesAreReportedInOneSentence) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n";
  const std::string rest =
      "property float z\nelement tristrips 2\nproperty list int int vertex_indices\nend_header\n";
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  const auto refused = [&](const std::string& bytes, const std::string& what) {
    const auto mesh = read(bytes);
    ASSERT_FALSE(mesh.ok()) << what;
    EXPECT_NE(mesh.error().find("a.ply"), std::string::npos) << mesh.error();
    EXPECT_NE(mesh.error().find(what), std::string::npos) << mesh.error();
    EXPECT_EQ(mesh.error().find('\n'), std::string::npos) << mesh.error();
  };
  refused(head + rest + points + "3 0 1 2\n4 0 1 2 3\n",
          ":14: 'tristrips' 2: refers to vertex 3, but the number of vertices is 3");
  refused(head + rest + points + "3 0 1 2\n4 0 1 -2 2\n", "refers to vertex -2");
  refused(head + rest + points + "3 0 1 2\n4 0 1 1.5 2\n", "refers to vertex 1.5");
  refused(head + rest + points + "3 0 1 2\n4 0 1 2\n",
          "'tristrips' 2: the file ends in the middle");
  refused(head + rest + points + "3 0 1 2\n400 0 1 2\n", "exceeds the file");
  refused(head + rest + points + "3 0 1 2\n-1 0 1 2\n", "a list of invalid length");
  refused(head + rest + points + "3 0 1 2\n3 0 x 2\n",
          ":14: 'tristrips' 2: expected a number, found 'x'");
  refused(head + rest + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n0\n",
          "'vertex' 2: expected a number, found 'nan'");
  refused(head + rest + points, "too short for the 2 of element 'tristrips'");
  refused(head + "element tristrips 0\nend_header\n" + points,
          "element 'vertex' has no property 'z'");
  refused(head + "property float z\nelement tristrips 1\nend_header\n" + points,
          "has no list 'vertex_indices'");
  refused(head + "property word z\nelement tristrips 1\nend_header\n" + points,
          ":6: unknown type 'word'");
  refused(head + "property z\nelement tristrips 1\nend_header\n" + points,
          ":6: the header has an unknown line");
  refused(head + "element tristrips -1\nend_header\n" + points,
          "invalid number '-1' of element 'tristrips'");
  refused(head + "element tristrips 1\n", "end_header");
  refused(head + "element tristrips 1\n" + points, ":7: the header has an unknown line");
  refused("ply\nformat ascii 1.0\nelement tristrips 0\nend_header\n",
          "has element 'vertex' 0 times");
  refused("ply\nelement tristrips 0\nend_header\n", "has no format");
  refused("ply\nformat utf-8 1.0\nelement tristrips 0\nend_header\n", "unknown format 'utf-8'");
  refused(head + rest + points + "2 0 1\n2 1 2\n", "has no triangles");
  // A binary file that is truncated anywhere.
  Random random;
  for (const Form form : {Form::little_endian, Form::big_endian}) {
    const std::string whole = file_of<float, int32_t>(form, 3, random);
    ASSERT_TRUE(parse_ply(whole, "a").ok());
    for (size_t size = 0; size < whole.size(); size += 3)
      ASSERT_FALSE(parse_ply(whole.substr(0, size), "a").ok()) << size;
  }
}

TEST(Ply, BrokenFilesAreRefusedOrSound) {
  Random random;
  for (const Form form : kForms) {
    const std::string whole = file_of<float, int32_t>(form, 3, random);
    for (int i = 0; i < 3000; i++) {
      std::string bytes = whole;
      for (int k = random.integer(1, 4); k > 0; k--)
        bytes[static_cast<size_t>(random.integer(0, static_cast<int>(bytes.size()) - 1))] ^=
            static_cast<char>(1 << random.integer(0, 7));
      const auto mesh = parse_ply(bytes, "a");
      if (!mesh) {
        ASSERT_FALSE(mesh.error().empty());
        ASSERT_EQ(mesh.error().find('\n'), std::string::npos) << mesh.error();
        continue;
      }
      for (const Vec3& p : mesh.value().vertices) ASSERT_TRUE(p.allFinite()) << random.note();
      for (const auto& t : mesh.value().triangles)
        for (const uint32_t v : t) ASSERT_LT(v, mesh.value().vertices.size()) << random.note();
    }
  }
}

}  // namespace
}  // namespace kibori::ply_tests
