// SPDX-License-Identifier: MIT
// Readers of STL, OBJ, PLY, OFF, GLB and glTF: one solid in many variants of each format, and files
// that must be refused. The solid is an L-shaped prism without symmetry. So a lost, turned or
// mirrored part changes its volume, area or centroid.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include <kibori/formats/glb.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/obj.h>
#include <kibori/formats/off.h>
#include <kibori/formats/ply.h>
#include <kibori/formats/polygons.h>
#include <kibori/formats/stl.h>
#include <kibori/formats/text.h>

#include "tests/support.h"

namespace kibori::mesh_readers_tests {
namespace {

using test::Random;
using Json = nlohmann::json;
using Notes = std::vector<std::string>;
const Vec3 kOrigin = Vec3::Zero();

// --- the solid

const std::vector<std::array<float, 3>> kPoints = {
    {0, 0, 0}, {30, 0, 0}, {30, 10, 0}, {10, 10, 0}, {10, 20, 0}, {0, 20, 0},
    {0, 0, 5}, {30, 0, 5}, {30, 10, 5}, {10, 10, 5}, {10, 20, 5}, {0, 20, 5}};
const std::vector<std::array<int, 3>> kFaces = {
    {3, 2, 1},  {3, 1, 0},  {3, 0, 5},  {3, 5, 4},   {9, 10, 11}, {9, 11, 6}, {9, 6, 7},
    {9, 7, 8},  {0, 1, 7},  {0, 7, 6},  {1, 2, 8},   {1, 8, 7},   {2, 3, 9},  {2, 9, 8},
    {3, 4, 10}, {3, 10, 9}, {4, 5, 11}, {4, 11, 10}, {5, 0, 6},   {5, 6, 11}};
// The solid's faces as polygons. The first two are concave, and a fan of triangles around their
// first corner overlaps itself.
const std::vector<std::vector<int>> kPolygons = {
    {1, 0, 5, 4, 3, 2}, {7, 8, 9, 10, 11, 6}, {0, 1, 7, 6},   {1, 2, 8, 7},
    {2, 3, 9, 8},       {3, 4, 10, 9},        {4, 5, 11, 10}, {5, 0, 6, 11}};

void expect_solid(const Result<TriangleMesh>& read, const std::string& what,
                  const Vec3& at = Vec3::Zero(), double tolerance = 1e-6) {
  ASSERT_TRUE(read.ok()) << what << ": " << read.error();
  const TriangleMesh& mesh = read.value();
  double volume = 0, area = 0;
  Vec3 moment = Vec3::Zero();
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - at, b = mesh.vertices[t[1]] - at,
               c = mesh.vertices[t[2]] - at;
    const double part = a.dot(b.cross(c)) / 6;
    volume += part;
    moment += part * (a + b + c) / 4;
    area += (b - a).cross(c - a).norm() / 2;
  }
  EXPECT_NEAR(volume, 2000, 2000 * tolerance) << what;
  EXPECT_NEAR(area, 1300, 1300 * tolerance) << what;
  EXPECT_LT((moment / volume - Vec3(12.5, 7.5, 2.5)).norm(), 12 * tolerance) << what;
  const Box box = mesh.bounds();
  EXPECT_LT((box.size() - Vec3(30, 20, 5)).norm(), 30 * tolerance) << what;
  EXPECT_LT((box.min - at).norm(), 30 * tolerance) << what;
}

using Parse = std::function<Result<TriangleMesh>(const std::string&, Notes*)>;

void expect_refused(const Result<TriangleMesh>& read, const std::string& expected) {
  ASSERT_FALSE(read.ok()) << expected;
  EXPECT_NE(read.error().find(expected), std::string::npos)
      << read.error() << "\n  lacks " << expected;
  EXPECT_EQ(read.error().find("part."), 0u) << read.error();
  EXPECT_EQ(read.error().find('\n'), std::string::npos) << read.error();
  EXPECT_LT(read.error().size(), 400u) << read.error();
}

// Reads each prefix of a file, and many files with changed bytes. The result is a valid mesh or one
// sentence.
void torment(const std::string& whole, const Parse& parse) {
  Random random;
  const auto check = [&](const std::string& bytes) {
    const auto read = parse(bytes, nullptr);
    if (!read) {
      ASSERT_FALSE(read.error().empty());
      ASSERT_EQ(read.error().find('\n'), std::string::npos) << read.error();
      return;
    }
    for (const Vec3& p : read.value().vertices) ASSERT_TRUE(p.allFinite()) << random.note();
    for (const auto& t : read.value().triangles)
      for (const uint32_t v : t) ASSERT_LT(v, read.value().vertices.size()) << random.note();
  };
  const size_t step = std::max<size_t>(1, whole.size() / 500);
  for (size_t size = 0; size < whole.size(); size += step) check(whole.substr(0, size));
  for (int i = 0; i < 2000; i++) {
    std::string bytes = whole;
    for (int k = random.integer(1, 4); k > 0; k--) {
      const auto at = static_cast<size_t>(random.integer(0, static_cast<int>(bytes.size()) - 1));
      switch (random.integer(0, 3)) {
        case 0:
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.integer(0, 7)));
          break;
        case 1:
          bytes.erase(at, static_cast<size_t>(random.integer(1, 12)));
          break;
        case 2:
          bytes.insert(at, bytes.substr(at / 2, static_cast<size_t>(random.integer(1, 30))));
          break;
        default:
          bytes.replace(at, 1, std::string("-1"));
      }
      if (bytes.empty()) bytes = "x";
    }
    check(bytes);
  }
}

std::string replaced(std::string text, const std::string& old, const std::string& fresh,
                     bool all = true) {
  size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  for (; at != std::string::npos; at = all ? text.find(old, at + fresh.size()) : std::string::npos)
    text.replace(at, old.size(), fresh);
  return text;
}
std::string number(float value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", static_cast<double>(value));
  return text;
}
template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string obj();  // the solid as an OBJ file

// --- STL

std::string ascii_stl() {
  std::string text = "solid part\n";
  for (const auto& face : kFaces) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (const int i : face) {
      const auto& p = kPoints[static_cast<size_t>(i)];
      text += "      vertex " + number(p[0]) + " " + number(p[1]) + " " + number(p[2]) + "\n";
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid part\n";
}
// `payload`: number of extra bytes after each triangle. The triangle's attribute stores it.
std::string binary_stl(const std::string& head = "x", size_t payload = 0) {
  std::string bytes = head;
  bytes.resize(80);
  append(bytes, static_cast<uint32_t>(kFaces.size()));
  for (const auto& face : kFaces) {
    bytes.append(12, '\0');
    for (const int i : face)
      for (const float x : kPoints[static_cast<size_t>(i)]) append(bytes, x);
    append(bytes, static_cast<uint16_t>(payload));
    bytes.append(payload, 'p');
  }
  return bytes;
}
std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

TEST(StlReader, AnySpellingIsRead) {
  const std::string plain = ascii_stl();
  const std::string one_line = replaced(plain, "\n", " ");
  for (const auto& [what, text] : std::vector<std::pair<std::string, std::string>>{
           {"plain", plain},
           {"upper case", upper(plain)},
           {"mixed case", replaced(plain, "facet normal", "Facet NORMAL")},
           {"byte order mark", "\xef\xbb\xbf" + plain},
           {"byte order mark and upper case", "\xef\xbb\xbf" + upper(plain)},
           {"blank lines", "\r\n\n  \t\n" + plain + "\n\n \n"},
           {"CR", replaced(plain, "\n", "\r")},
           {"CR LF", replaced(plain, "\n", "\r\n")},
           {"long name", replaced(plain, "solid part", "solid " + std::string(3000, '/'))},
           {"long name, CR",
            replaced(replaced(plain, "solid part", "solid " + std::string(90000, 'n')), "\n",
                     "\r")},
           {"NUL in the name", replaced(plain, "solid part", std::string("solid a\0b", 9))},
           {"NUL at the end", plain + std::string(100, '\0')},
           {"no name", replaced(plain, "solid part", "solid")},
           {"name with keywords", replaced(plain, "solid part", "solid facet of a vertex loop")},
           {"one line", one_line},
           {"one line, CR at the end", one_line + "\r"},
           {"first facet on the solid's line",
            replaced(plain, "solid part\n", "solid part ", false)},
           {"facets on one line", replaced(plain, "endfacet\n", "endfacet ")},
           {"a facet a line", replaced(replaced(replaced(replaced(plain, "endloop\n", "endloop "),
                                                         "outer loop\n", "outer loop "),
                                                "0 0 0\n", "0 0 0 "),
                                       "\n      vertex", " vertex")},
           {"normals that are none", replaced(plain, "normal 0 0 0", "normal nan -1.#IND 1,5")},
           {"no normals", replaced(plain, "facet normal 0 0 0", "facet")},
           {"two solids",
            replaced(plain, "  facet normal 0 0 0\n    outer loop\n      vertex 0 0 0",
                     "endsolid part\n\nsolid b\n  facet normal 0 0 0\n    outer loop\n      vertex "
                     "0 0 0",
                     false)},
           {"tabs", replaced(plain, " ", "\t")},
           {"exponents and signs",
            replaced(replaced(plain, "30 10", "+3.0E+1 1e1"), " 20", " 0200.0e-1")},
           {"no final line end", plain.substr(0, plain.size() - 1)},
           {"a word after the end", plain + "created by a program\n"}}) {
    Notes notes;
    expect_solid(parse_stl(text, "part.stl", &notes), what);
    EXPECT_EQ(notes.size(), what.starts_with("a word") ? 1u : 0u) << what;
  }
}

TEST(StlReader, BinaryFilesOfAnyHead) {
  for (const char* head : {"", "x", "solid part", "SOLID facet normal 0 0 0", "\xef\xbb\xbfsolid",
                           "solid a\nfacet normal 0 0 0\nouter loop"})
    expect_solid(parse_stl(binary_stl(head), "part.stl"), head);
  for (const size_t payload : {1, 2, 50, 300}) {
    Notes notes;
    expect_solid(parse_stl(binary_stl("x", payload), "part.stl", &notes),
                 "payload " + std::to_string(payload));
    EXPECT_TRUE(notes.empty());
  }
  // The attribute of a triangle may be a colour. It is not a length.
  std::string colors = binary_stl();
  for (size_t i = 0; i < kFaces.size(); i++) colors[84 + 50 * i + 49] = '\x7f';
  expect_solid(parse_stl(colors, "part.stl"), "colours");
  for (const size_t more : {1, 2, 16, 49, 51, 512}) {
    Notes notes;
    expect_solid(parse_stl(binary_stl() + std::string(more, '\0'), "part.stl", &notes), "trailing");
    ASSERT_EQ(notes.size(), 1u) << more;
    EXPECT_NE(notes[0].find(std::to_string(more) + " bytes after the last of 20"),
              std::string::npos)
        << notes[0];
    expect_solid(parse_stl(colors + std::string(more, '\0'), "part.stl"), "colours, trailing");
  }
}

TEST(StlReader, WrongFilesAreRefused) {
  const std::string plain = ascii_stl();
  const auto refused = [](const std::string& bytes, const std::string& expected) {
    expect_refused(parse_stl(bytes, "part.stl"), expected);
  };
  refused(binary_stl() + std::string(50, '\0'), "promises 20 triangles, but the file holds 21");
  for (const uint32_t count : {0u, 5u, 21u, 0x7fffffffu}) {
    std::string lying = binary_stl();
    std::memcpy(lying.data() + 80, &count, 4);
    refused(lying,
            "byte 80 promises " + std::to_string(count) + " triangles, but the file holds 20");
  }
  refused(binary_stl().substr(0, 1000), "cut short?");
  refused(plain.substr(0, plain.size() / 2), "part.stl:");
  refused(replaced(plain, "endsolid part\n", ""), "the file ends in the middle");
  refused(replaced(plain, "vertex 30 10 0", "vertex 30 1.#IND 0", false),
          "part.stl:5: expected a coordinate, found '1.#IND'");
  refused(replaced(replaced(plain, "vertex 30 10 0", "vertex 30 10,5 0", false), "\n", "\r"),
          "part.stl:5: expected a coordinate, found '10,5'");
  refused(replaced(plain, "    endloop", "      vertex 1 2 3\n    endloop", false),
          "more than three vertices");
  refused(replaced(plain, "  endfacet", "  endfaced", false), "found 'endfaced'");
  refused(obj(), "is text, but has no 'solid'");
  refused("\xff\xfes\0o\0l\0i\0d\0", "UTF-16");
  refused("solid a\nendsolid " + std::string(5000, 'z') + "\n\x01 facet normal 0 0 0", "found");
}

// --- OBJ

std::string obj_points() {
  std::string text;
  for (const auto& p : kPoints)
    text += "v " + number(p[0]) + " " + number(p[1]) + " " + number(p[2]) + "\n";
  return text;
}
// A face for each list of vertices. `corner` spells vertex i.
template <class Lists>
std::string obj_faces(const Lists& lists, const std::function<std::string(int)>& corner) {
  std::string text;
  for (const auto& face : lists) {
    text += "f";
    for (const int i : face) text += " " + corner(i);
    text += "\n";
  }
  return text;
}
std::string plain_index(int i) { return std::to_string(i + 1); }
std::string obj() { return obj_points() + obj_faces(kFaces, plain_index); }

TEST(ObjReader, AnySpellingIsRead) {
  const std::string points = obj_points(), faces = obj_faces(kFaces, plain_index),
                    plain = points + faces;
  const auto with = [&](const std::function<std::string(int)>& corner) {
    return points + obj_faces(kFaces, corner);
  };
  const std::string n = "\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"plain", plain},
      {"CR", replaced(plain, "\n", "\r")},
      {"CR LF", replaced(plain, "\n", "\r\n")},
      {"no final line end", plain.substr(0, plain.size() - 1)},
      {"byte order mark", "\xef\xbb\xbf" + plain},
      {"indented", replaced(replaced(plain, "v ", " \tv "), "f ", "   f ")},
      {"tabs and spaces", replaced(plain, " ", " \t ") + "  \n\t\n"},
      {"polygons", points + obj_faces(kPolygons, plain_index)},
      {"faces first", faces + points},
      {"polygons first", obj_faces(kPolygons, plain_index) + points},
      {"from the end", with([](int i) { return std::to_string(i - 12); })},
      {"v/vt", with([](int i) { return plain_index(i) + "/1"; })},
      {"v//vn", with([](int i) { return plain_index(i) + "//7"; })},
      {"v/vt/vn", with([](int i) { return plain_index(i) + "/99/-4"; })},
      {"v/", with([](int i) { return plain_index(i) + "/"; })},
      {"v//", with([](int i) { return plain_index(i) + "//"; })},
      {"from the end, v/vt/vn", with([](int i) { return std::to_string(i - 12) + "/-1/-1"; })},
      {"comments",
       "# a \\\n" + replaced(replaced(plain, " 0\n", " 0 # zero \\\n"), "f ", "#\\\nf ")},
      {"continued name", points + "usemtl wood\\\n" + faces},
      {"continued names", replaced(points, "v 30 0 0\n", "g a b\\\nv 30 0 0\n") +
                              "o x\\\nmtllib m \\\ns 1\\\n" + faces},
      {"continued lines",
       replaced(replaced(plain, "f 4 3 2", "f 4 \\\n 3 \\\n2"), "v 30 0 0", "v 30\\\n0 0")},
      {"continued, CR LF",
       replaced(replaced(plain, "f 4 3 2", "f 4 \\\n 3 2 \\  \n\n"), "\n", "\r\n")},
      {"continued last line", plain.substr(0, plain.size() - 1) + " \\"},
      {"groups", "o L\n" + points + "vt 0 0\nvn 0 0 1\ng one two\ns off\n" + faces + "g\n"},
      {"colours", replaced(plain, " 0\n", " 0 0.5 0.2 0.1\n")},
      {"colours with alpha", replaced(plain, " 0\n", " 0 0.5 0.2 0.1 1.0\n")},
      {"weights of one", replaced(plain, " 0\n", " 0 1.0\n")},
      {"exponents", replaced(replaced(points, "30 ", "+3.0e+01 "), " 5\n", " .5E1\n") + faces},
      {"unused vertices", "v 99 99 99\n" + points + "v -8 1e9 2\n" +
                              obj_faces(kFaces, [](int i) { return std::to_string(i + 2); })},
      {"faces of two corners", plain + "f 1 2\nf 3\n"},
      {"lines and points", plain + "l 1 2 3\np 4\n"},
      {"weights", replaced(plain, " 0\n", " 0 0.5\n")},
      {"an unknown line", plain + "quux 1 2 3\nquux\n"},
      {"old faces", replaced(plain, "f ", "fo ")}};
  for (const auto& [what, text] : cases) {
    Notes notes;
    expect_solid(parse_obj(text, "part.obj", &notes), what);
    const bool noted = what == "faces of two corners" || what == "lines and points" ||
                       what == "weights" || what == "an unknown line";
    EXPECT_EQ(notes.size(), noted ? 1u : 0u) << what << (notes.empty() ? "" : notes[0]);
  }
}

TEST(ObjReader, FarFromTheOrigin) {
  for (const double far : {1e4, 1e6, 1e8, 1e9}) {
    std::string text;
    for (const auto& p : kPoints) {
      char line[99];
      std::snprintf(line, sizeof line, "v %.3f %.3f %.3f\n",
                    static_cast<double>(p[0]) + far + 0.125, static_cast<double>(p[1]) - far,
                    static_cast<double>(p[2]) + 0.25);
      text += line;
    }
    expect_solid(parse_obj(text + obj_faces(kFaces, plain_index), "part.obj"), std::to_string(far),
                 Vec3(far + 0.125, -far, 0.25), 1e-5);
  }
  // Near the origin, coordinates are rounded to float32, as in a binary file.
  const auto near = parse_obj(replaced(obj(), "v 30 ", "v 30.1 "), "part.obj");
  ASSERT_TRUE(near.ok());
  EXPECT_EQ(near.value().vertices[1].x(), static_cast<double>(30.1f));
}

TEST(ObjReader, WrongFilesAreRefused) {
  const auto refused = [](const std::string& bytes, const std::string& expected) {
    expect_refused(parse_obj(bytes, "part.obj"), expected);
  };
  const std::string plain = obj();
  for (const char* wrong : {"1.#IND", "1.#INF", "nan", "inf", "0x1E", "3.0.0", "30abc", "30,5",
                            "1e999", "--3", "+-3", "+"})
    refused(replaced(plain, "v 30 0 0", std::string("v 30 ") + wrong + " 0"),
            "part.obj:2: expected a number, found '" + std::string(wrong) + "'");
  refused(replaced(plain, "v 30 0 0", "v 30 0 0 1.#IND"), "part.obj:2: expected a number");
  refused(replaced(plain, "v 30 0 0", "v 30 0"), "part.obj:2: a vertex has 2 coordinates");
  refused(replaced(plain, "f 4 3 2", "f 4 3 13"),
          "part.obj:13: a face refers to vertex 13, but the number of vertices is 12");
  refused(replaced(plain, "f 4 3 2", "f 4 3 -13"), "part.obj:13: a face refers to vertex -13");
  refused(replaced(plain, "f 4 3 2", "f 4 3 0"), "counted from 1");
  refused(replaced(plain, "f 4 3 2", "f 4 3 99999999999999999999"),
          "part.obj:13: expected the number");
  refused(replaced(plain, "f 4 3 2", "f 4 3 4000000000"), "refers to vertex 4000000000");
  for (const char* wrong : {"2.5", "x", "2/a", "2/1/1/1", "/2", "2 / 3"})
    refused(replaced(plain, "f 4 3 2", std::string("f 4 3 ") + wrong),
            "part.obj:13: expected the number of a vertex");
  refused("", "is an OBJ file");
  refused("nonsense\n", "is an OBJ file");
  refused(std::string(100000, '\xff'), "is an OBJ file");
  refused("\xff\xfev\0 \0", "UTF-16");
  refused(obj_points(), "only points or lines (12");
  refused(obj_points() + "l 1 2 3\n", "only points or lines");
  refused(obj_points() + "surf 0 1 0 1 1 2 3 4\n", "free-form");
}

// --- PLY

std::string ply_head(const std::string& form = "ascii", const std::string& elements = "vf") {
  std::string text = "ply\nformat " + form + " 1.0\n";
  for (const char e : elements)
    text += e == 'v'   ? "element vertex 12\nproperty float x\nproperty float y\nproperty float z\n"
            : e == 'f' ? "element face 20\nproperty list uchar int vertex_indices\n"
                       : "element camera 1\nproperty float view\n";
  return text + "end_header\n";
}
std::string ply_body(const std::string& elements = "vf") {
  std::string text;
  for (const char e : elements) {
    if (e == 'v')
      for (const auto& p : kPoints)
        text += number(p[0]) + " " + number(p[1]) + " " + number(p[2]) + "\n";
    else if (e == 'f')
      for (const auto& f : kFaces)
        text += "3 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " +
                std::to_string(f[2]) + "\n";
    else
      text += "1.5\n";
  }
  return text;
}
std::string ply_bytes(const std::string& elements, bool big) {
  std::string bytes;
  const auto put = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (big) std::reverse(raw, raw + sizeof value);
    bytes.append(raw, sizeof value);
  };
  for (const char e : elements) {
    if (e == 'v')
      for (const auto& p : kPoints)
        for (const float x : p) put(x);
    else if (e == 'f')
      for (const auto& f : kFaces) {
        put(uint8_t{3});
        for (const int i : f) put(i);
      }
    else
      put(1.5f);
  }
  return bytes;
}

Result<TriangleMesh> read_ply(const std::string& bytes, Notes* notes = nullptr) {
  return parse_ply(bytes, "part.ply", notes);
}

TEST(PlyReader, ElementsInAnyOrder) {
  for (const char* order : {"vf", "fv", "cvf", "vcf", "vfc", "cfv", "fcv", "fvc", "cvcfc"}) {
    Notes notes;
    const std::string ascii = ply_head("ascii", order) + ply_body(order);
    expect_solid(read_ply(ascii, &notes), order);
    expect_solid(read_ply(replaced(ascii, "\n", "\r\n"), &notes), order);
    expect_solid(read_ply(replaced(ascii, "\n", "\r"), &notes), order);
    expect_solid(read_ply(ascii.substr(0, ascii.size() - 1), &notes), order);
    for (const bool big : {false, true}) {
      const std::string form = big ? "binary_big_endian" : "binary_little_endian",
                        head = ply_head(form, order), bytes = ply_bytes(order, big);
      for (const char* end : {"\n", "\r\n", "\r"})
        expect_solid(read_ply(replaced(head, "\n", end) + bytes, &notes), form + " " + order);
    }
    EXPECT_TRUE(notes.empty()) << notes[0];
  }
}

TEST(PlyReader, AnySpellingIsRead) {
  const std::string head = ply_head(), body = ply_body(), plain = head + body;
  // The data begins with a line end, under every line end of the header.
  for (const char* end : {"\n", "\r\n", "\r"})
    for (const char first : {'\n', '\r'}) {
      std::string bytes = ply_bytes("vf", false);
      bytes[0] = first;  // 1.4e-44, nearly zero
      expect_solid(read_ply(replaced(ply_head("binary_little_endian"), "\n", end) + bytes),
                   "first byte is a line end");
    }
  std::string polygons;
  for (const auto& face : kPolygons) {
    polygons += std::to_string(face.size());
    for (const int i : face) polygons += " " + std::to_string(i);
    polygons += "\n";
  }
  const std::vector<std::pair<std::string, std::string>> cases{
      {"byte order mark", "\xef\xbb\xbf" + plain},
      {"empty faces", replaced(head, "face 20", "face 23") + body + "0\n1 4\n2 1 2\n"},
      {"empty faces in between",
       replaced(replaced(head, "face 20", "face 21") + body, "3 3 2 1\n", "0\n3 3 2 1\n")},
      {"polygons", replaced(head, "face 20", "face 8") + ply_body("v") + polygons},
      {"polygons before vertices",
       replaced(ply_head("ascii", "fv"), "face 20", "face 8") + polygons + ply_body("v")},
      {"another name of the list", replaced(plain, "vertex_indices", "vertex_index")},
      {"spaces and comments",
       replaced(plain, "end_header", "comment element face 7\n obj_info x \n\nend_header ")},
      {"doubles", replaced(plain, "property float", "property double")},
      {"long rows", replaced(plain, "3 3 2 1\n", "3 3\n2\n1\n")},
      {"columns without a name", replaced(plain, " 0\n", " 0 255 0 7\n")},
      {"numbers after the end", plain + "1 2 3\n"}};
  for (const auto& [what, text] : cases) {
    Notes notes;
    expect_solid(read_ply(text, &notes), what);
    const bool noted = what.starts_with("columns") || what.starts_with("numbers");
    EXPECT_EQ(notes.size(), noted ? 1u : 0u) << what;
  }
  Notes notes;
  expect_solid(read_ply(ply_head("binary_little_endian") + ply_bytes("vf", false) + "xyz", &notes),
               "more");
  EXPECT_EQ(notes.size(), 1u);
}

TEST(PlyReader, WrongFilesAreRefused) {
  const std::string plain = ply_head() + ply_body();
  const auto refused = [](const std::string& bytes, const std::string& expected) {
    expect_refused(read_ply(bytes), expected);
  };
  refused(replaced(ply_head(), "face 20", "face 0") + ply_body("v"), "has only points (12)");
  refused(ply_head("ascii", "v") + ply_body("v"), "has only points (12)");
  refused(replaced(plain, "vertex_indices", "corners"), "no list 'vertex_indices'");
  for (const char* wrong : {"1.#IND", "nan", "0x1E", "30abc"})
    refused(replaced(plain, "30 0 0", std::string("30 ") + wrong + " 0"), "'vertex' 2");
  refused(replaced(plain, "3 3 2 1", "3 3 2 12"),
          "refers to vertex 12, but the number of vertices is 12");
  refused(replaced(plain, "30 0 0\n", "30 0 0 "), "part.ply");  // two rows on a line
  refused(ply_head("binary_little_endian") + ply_bytes("vf", false).substr(0, 390),
          "export it again");
}

// --- OFF

std::string off_points(const std::string& more = "") {
  std::string text;
  for (const auto& p : kPoints)
    text += number(p[0]) + " " + number(p[1]) + " " + number(p[2]) + more + "\n";
  return text;
}
template <class Lists>
std::string off_faces(const Lists& lists, const std::string& more = "") {
  std::string text;
  for (const auto& face : lists) {
    text += std::to_string(face.size());
    for (const int i : face) text += " " + std::to_string(i);
    text += more + "\n";
  }
  return text;
}

TEST(OffReader, AnySpellingIsRead) {
  const std::string points = off_points(), faces = off_faces(kFaces), body = points + faces,
                    plain = "OFF\n12 20 0\n" + body;
  std::string fourfold;
  for (const auto& p : kPoints)
    fourfold += number(2 * p[0]) + " " + number(2 * p[1]) + " " + number(2 * p[2]) + " 2\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"plain", plain},
      {"CR", replaced(plain, "\n", "\r")},
      {"CR LF", replaced(plain, "\n", "\r\n")},
      {"byte order mark", "\xef\xbb\xbf" + plain},
      {"no final line end", plain.substr(0, plain.size() - 1)},
      {"counts on the first line", "OFF 12 20 30\n" + body},
      {"no number of edges", "OFF\n12 20\n" + body},
      {"no word", "12 20 30\n" + body},
      {"comments",
       "OFF # a\n# b\n\n12 20 0 # c\n\n" + replaced(body, "3 3 2 1\n", "# d\n3 3 2 1 # e\n\n")},
      {"polygons", "OFF\n12 8 0\n" + points + off_faces(kPolygons)},
      {"colours of faces", "OFF\n12 20 0\n" + points + off_faces(kFaces, " 255 0 0")},
      {"polygons and colours", "OFF\n12 8 0\n" + points + off_faces(kPolygons, " 0.1 0.2 0.3 1")},
      {"colours", "COFF\n12 20 0\n" + off_points(" 255 128 0 255") + faces},
      {"colours of three numbers", "COFF\n12 20 0\n" + off_points(" 1 0.5 0") + faces},
      {"colours under a plain word", "OFF\n12 20 0\n" + off_points(" 1 0.5 0") + faces},
      {"normals", "NOFF\n12 20 0\n" + off_points(" 0 0 1") + faces},
      {"texture coordinates", "STOFF\n12 20 0\n" + off_points(" 0.5 0.5") + faces},
      {"all of them", "STCNOFF\n12 20 0\n" + off_points(" 0 0 1 1 1 1 1 0.5 0.5") + faces},
      {"fourth coordinate", "4OFF\n12 20 0\n" + fourfold + faces},
      {"dimension three", "nOFF\n3\n12 20 0\n" + body},
      {"all on one line", replaced(plain, "\n", " ")},
      {"one line, normals", replaced("NOFF\n12 20 0\n" + off_points(" 0 0 1") + faces, "\n", " ")},
      {"vertices on one line",
       "OFF\n12 8 0\n" + replaced(points, "\n", " ") + "\n" + off_faces(kPolygons)},
      {"more lines", plain + "3 0 1 2\n"}};
  for (const auto& [what, text] : cases) {
    Notes notes;
    expect_solid(parse_off(text, "part.off", &notes), what);
    EXPECT_EQ(notes.size(), what == "more lines" ? 1u : 0u) << what;
  }
}

TEST(OffReader, WrongFilesAreRefused) {
  const std::string plain = "OFF\n12 20 0\n" + off_points() + off_faces(kFaces);
  const auto refused = [](const std::string& bytes, const std::string& expected) {
    expect_refused(parse_off(bytes, "part.off"), expected);
  };
  refused("", "is empty");
  refused("solid x\n", "begins with 'solid'");
  refused("OFF BINARY\n", "binary OFF");
  refused("OFF\n", "the number of vertices");
  refused("nOFF 4\n1 1 0\n", "4 dimensions");
  refused("OFF\n1000000000 1000000000 0\n", "announces more vertices or faces");
  refused("OFF\n1e300 1 0\n", "announces more vertices or faces");
  refused("OFF\n-1 1 0\n", "part.off:2: expected the number of vertices");
  for (const char* wrong : {"12", "-1", "99999999999", "nan", "1.5", "x"})
    refused(replaced(plain, "3 3 2 1", std::string("3 3 2 ") + wrong),
            "part.off:15: a face refers to a missing vertex");
  refused(replaced(plain, "3 3 2 1", "4 3 2 1"), "part.off:15: a face of 4 corners lists fewer");
  refused(replaced(plain, "30 0 0\n", "30 0\n"), "part.off:4: expected a coordinate");
  refused(replaced(plain, "30 0 0\n", "30 1.#IND 0\n"), "found '1.#IND'");
  refused(replaced(plain, "\n12 20 0", "\n12 21 0"), "ends in the middle of its faces");
  refused(replaced(plain, "\n", " ") + "7", "more numbers");
  refused(plain.substr(0, plain.size() / 2), "ends in the middle");
}

// --- GLB

struct GlbBuilder {
  Json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
  std::string bytes;

  // Metres with y up.
  static std::array<float, 3> point(size_t i) {
    const auto& p = kPoints[i];
    return {p[0] / 1000, p[2] / 1000, -p[1] / 1000};
  }
  int view(const std::string& data, int stride = 0) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    Json about = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", data.size()}};
    if (stride) about["byteStride"] = stride;
    json["bufferViews"].push_back(about);
    bytes += data;
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }
  int accessor(Json about) {
    json["accessors"].push_back(std::move(about));
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  int points() {
    std::string data;
    for (size_t i = 0; i < kPoints.size(); i++)
      for (const float x : point(i)) append(data, x);
    return accessor(
        {{"bufferView", view(data)}, {"componentType", 5126}, {"count", 12}, {"type", "VEC3"}});
  }
  template <class T>
  int indices(const std::vector<int>& list, int type) {
    std::string data;
    for (const int i : list) append(data, static_cast<T>(i));
    return accessor({{"bufferView", view(data)},
                     {"componentType", type},
                     {"count", list.size()},
                     {"type", "SCALAR"}});
  }
  void primitive(int position, int index, int mode = 4) {
    Json one = {{"attributes", {{"POSITION", position}}}};
    if (index >= 0) one["indices"] = index;
    if (mode != 4) one["mode"] = mode;
    if (json["meshes"].is_null()) json["meshes"].push_back(Json::object());
    json["meshes"][0]["primitives"].push_back(one);
    json["nodes"] = {{{"mesh", 0}}};
    json["scenes"] = {{{"nodes", {0}}}};
  }
  // `pad`: JSON and data end at multiples of four.
  std::string file(bool pad = true) const {
    Json whole = json;
    if (!bytes.empty()) whole["buffers"] = {{{"byteLength", bytes.size()}}};
    return file_of(whole.dump(), bytes, pad);
  }
  static std::string file_of(std::string text, std::string data, bool pad = true) {
    if (pad) text.resize((text.size() + 3) / 4 * 4, ' ');
    if (pad) data.resize((data.size() + 3) / 4 * 4);
    std::string chunks;
    append(chunks, static_cast<uint32_t>(text.size()));
    chunks += "JSON" + text;
    if (!data.empty()) {
      append(chunks, static_cast<uint32_t>(data.size()));
      chunks += std::string("BIN\0", 4) + data;
    }
    std::string file("glTF\2\0\0\0", 8);
    append(file, static_cast<uint32_t>(12 + chunks.size()));
    return file + chunks;
  }
};

std::vector<int> flat_faces() {
  std::vector<int> list;
  for (const auto& face : kFaces) list.insert(list.end(), face.begin(), face.end());
  return list;
}
GlbBuilder plain_glb() {
  GlbBuilder glb;
  const int points = glb.points();
  glb.primitive(points, glb.indices<uint16_t>(flat_faces(), 5123));
  return glb;
}
Result<TriangleMesh> read_glb(const std::string& bytes, Notes* notes = nullptr) {
  return parse_glb(bytes, "part.glb", notes);
}
std::string base64(const std::string& bytes) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; k++)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; k++)
      text += i + k > bytes.size() ? '=' : letters[bits >> (18 - 6 * k) & 63];
  }
  return text;
}
constexpr double kGlb = 1e-5;  // float32 metres

TEST(GlbReader, Containers) {
  const GlbBuilder glb = plain_glb();
  expect_solid(read_glb(glb.file()), "plain", kOrigin, kGlb);
  // The chunks are not padded, whatever the length of the JSON.
  for (int more = 0; more < 4; more++) {
    GlbBuilder longer = glb;
    longer.json["asset"]["generator"] = std::string(static_cast<size_t>(more), 'x');
    expect_solid(read_glb(longer.file(false)), "not padded", kOrigin, kGlb);
    // The length of the JSON chunk does not count its padding.
    const std::string text = [&] {
      Json whole = longer.json;
      whole["buffers"] = {{{"byteLength", glb.bytes.size()}}};
      return whole.dump();
    }();
    std::string file = GlbBuilder::file_of(text, glb.bytes);
    const auto size = static_cast<uint32_t>(text.size());
    std::memcpy(file.data() + 12, &size, 4);
    expect_solid(read_glb(file), "length without padding", kOrigin, kGlb);
    // The JSON is padded with NUL bytes.
    for (size_t i = 20 + text.size(); i < 20 + (text.size() + 3) / 4 * 4; i++) file[i] = '\0';
    file = replaced(file, std::string("glTF"), "glTF");
    const auto padded = static_cast<uint32_t>((text.size() + 3) / 4 * 4);
    std::memcpy(file.data() + 12, &padded, 4);
    expect_solid(read_glb(file), "NUL", kOrigin, kGlb);
  }
  // A buffer inside the JSON, with and without the container.
  Json whole = glb.json;
  whole["buffers"] = {{{"byteLength", glb.bytes.size()},
                       {"uri", "data:application/octet-stream;base64," + base64(glb.bytes)}}};
  expect_solid(read_glb(GlbBuilder::file_of(whole.dump(), "")), "data URI", kOrigin, kGlb);
  expect_solid(read_glb(GlbBuilder::file_of(whole.dump(), "ignored!")), "data URI, BIN", kOrigin,
               kGlb);
  expect_solid(read_glb(whole.dump(2)), "JSON alone", kOrigin, kGlb);
  expect_solid(read_glb("\xef\xbb\xbf\n" + whole.dump(2)), "JSON alone", kOrigin, kGlb);
  // A name that is not UTF-8. Then a file without its last byte of padding.
  GlbBuilder latin = glb;
  latin.json["nodes"][0]["name"] = "Knauf @";
  expect_solid(read_glb(replaced(latin.file(), "Knauf @", "Knauf \xf6")), "Latin", kOrigin, kGlb);
  GlbBuilder bytes = glb;
  bytes.bytes.resize(bytes.bytes.size() + 1);
  const std::string file = bytes.file();
  expect_solid(read_glb(file.substr(0, file.size() - 3)), "padding is missing", kOrigin, kGlb);
}

TEST(GlbReader, Accessors) {
  // Indices of every type, or none.
  for (const int type : {5121, 5123, 5125}) {
    GlbBuilder glb;
    const int points = glb.points();
    glb.primitive(points, type == 5121   ? glb.indices<uint8_t>(flat_faces(), type)
                          : type == 5123 ? glb.indices<uint16_t>(flat_faces(), type)
                                         : glb.indices<uint32_t>(flat_faces(), type));
    expect_solid(read_glb(glb.file()), std::to_string(type), kOrigin, kGlb);
  }
  {
    GlbBuilder glb;
    std::string data;
    for (const int i : flat_faces())
      for (const float x : GlbBuilder::point(static_cast<size_t>(i))) append(data, x);
    glb.primitive(glb.accessor({{"bufferView", glb.view(data)},
                                {"componentType", 5126},
                                {"count", 60},
                                {"type", "VEC3"}}),
                  -1);
    expect_solid(read_glb(glb.file()), "no indices", kOrigin, kGlb);
  }
  {  // Interleaved with normals, in a view with an offset inside.
    GlbBuilder glb;
    std::string data(8, 'x');
    for (size_t i = 0; i < kPoints.size(); i++) {
      for (int k = 0; k < 3; k++) append(data, 77.0f);
      for (const float x : GlbBuilder::point(i)) append(data, x);
      append(data, uint32_t{0xffffffff});
    }
    const int points = glb.accessor({{"bufferView", glb.view(data, 28)},
                                     {"byteOffset", 20},
                                     {"componentType", 5126},
                                     {"count", 12},
                                     {"type", "VEC3"}});
    glb.primitive(points, glb.indices<uint16_t>(flat_faces(), 5123));
    expect_solid(read_glb(glb.file()), "interleaved", kOrigin, kGlb);
  }
  for (const bool zeros : {false, true}) {  // sparse, upon other values or upon zeros
    GlbBuilder glb;
    std::string base, values, places;
    int count = 0;
    for (size_t i = 0; i < kPoints.size(); i++) {
      const auto p = GlbBuilder::point(i);
      const bool replace = zeros ? i != 0 : i % 3 == 1;
      for (const float x : p) append(base, replace ? 9.0f : x);
      if (!replace) continue;
      count++;
      append(places, static_cast<uint8_t>(i));
      for (const float x : p) append(values, x);
    }
    Json about = {{"componentType", 5126}, {"count", 12}, {"type", "VEC3"}};
    if (!zeros) about["bufferView"] = glb.view(base);
    about["sparse"] = {{"count", count},
                       {"indices", {{"bufferView", glb.view(places)}, {"componentType", 5121}}},
                       {"values", {{"bufferView", glb.view(values)}}}};
    const int points = glb.accessor(about);
    glb.primitive(points, glb.indices<uint16_t>(flat_faces(), 5123));
    expect_solid(read_glb(glb.file()), "sparse", kOrigin, kGlb);
  }
}

// Positions as 8 and 16 bits, with the scale of the node.
template <class T>
GlbBuilder quantized(int type, bool normalized, double units_per_mm) {
  GlbBuilder glb;
  std::string data;
  for (size_t i = 0; i < kPoints.size(); i++) {
    for (const float x : GlbBuilder::point(i))
      append(data, static_cast<T>(std::lround(static_cast<double>(x) * 1000 * units_per_mm)));
    data.resize((data.size() + 3) / 4 * 4);
  }
  const int stride = static_cast<int>(data.size() / kPoints.size());
  const int points = glb.accessor({{"bufferView", glb.view(data, stride)},
                                   {"componentType", type},
                                   {"count", 12},
                                   {"normalized", normalized},
                                   {"type", "VEC3"}});
  glb.primitive(points, glb.indices<uint16_t>(flat_faces(), 5123));
  const double scale =
      (normalized ? static_cast<double>(std::numeric_limits<T>::max()) : 1) / units_per_mm / 1000;
  glb.json["nodes"][0]["scale"] = {scale, scale, scale};
  glb.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  glb.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  return glb;
}

TEST(GlbReader, Quantized) {
  for (const bool normalized : {false, true}) {
    expect_solid(read_glb(quantized<int16_t>(5122, normalized, 100).file()), "int16", kOrigin,
                 kGlb);
    expect_solid(read_glb(quantized<int8_t>(5120, normalized, 4).file()), "int8", kOrigin, kGlb);
  }
  // Unsigned numbers cannot hold -20 mm: the node turns the solid instead.
  for (const bool normalized : {false, true}) {
    GlbBuilder glb;
    std::string data;
    for (const auto& p : kPoints) {
      for (const float x : p) append(data, static_cast<uint16_t>(x * 1000));
      data.resize((data.size() + 3) / 4 * 4);
    }
    const int points = glb.accessor({{"bufferView", glb.view(data, 8)},
                                     {"componentType", 5123},
                                     {"count", 12},
                                     {"normalized", normalized},
                                     {"type", "VEC3"}});
    glb.primitive(points, glb.indices<uint16_t>(flat_faces(), 5123));
    const double scale = (normalized ? 65535.0 : 1) / 1e6;
    // By columns: x stays, y becomes -z, z becomes y.
    glb.json["nodes"][0]["matrix"] = {scale, 0, 0, 0, 0, 0, -scale, 0, 0, scale, 0, 0, 0, 0, 0, 1};
    expect_solid(read_glb(glb.file()), "uint16", kOrigin, kGlb);
  }
}

TEST(GlbReader, StripsAndFans) {
  GlbBuilder glb;
  const int points = glb.points();
  // The sides as one strip around, the ends as fans around the inner corner.
  glb.primitive(points, glb.indices<uint16_t>({6, 0, 7, 1, 8, 2, 9, 3, 10, 4, 11, 5, 6, 0}, 5123),
                5);
  glb.primitive(points, glb.indices<uint8_t>({3, 2, 1, 0, 5, 4}, 5121), 6);
  glb.primitive(points, glb.indices<uint8_t>({9, 10, 11, 6, 7, 8}, 5121), 6);
  glb.primitive(points, glb.indices<uint8_t>({0, 1, 2}, 5121), 1);
  glb.primitive(points, -1, 0);
  Notes notes;
  const auto strip = read_glb(glb.file(), &notes);
  // The orientation of the triangles alternates along a strip. If it is read wrongly, the solid is
  // inside out.
  expect_solid(strip, "strip and fans", kOrigin, kGlb);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("points and lines"), std::string::npos);
  // Strips joined by triangles without area.
  GlbBuilder joined;
  const int all = joined.points();
  joined.primitive(
      all, joined.indices<uint16_t>({6, 0, 7, 1, 8, 2, 9, 3, 3, 9, 9, 3, 10, 4, 11, 5, 6, 0}, 5123),
      5);
  joined.primitive(all, joined.indices<uint8_t>({3, 2, 1, 0, 5, 4}, 5121), 6);
  joined.primitive(all, joined.indices<uint8_t>({9, 10, 11, 6, 7, 8}, 5121), 6);
  expect_solid(read_glb(joined.file()), "joined strips", kOrigin, kGlb);
}

TEST(GlbReader, NodesPlaceMeshes) {
  GlbBuilder glb = plain_glb();
  const double half = std::sqrt(0.5);
  // The child undoes the parent's quarter turn about y, scale and shift.
  glb.json["nodes"] = {
      {{"children", {1}},
       {"rotation", {0, half, 0, half}},
       {"scale", {2, 2, 2}},
       {"translation", {1, 2, 3}}},
      {{"children", {2}}, {"rotation", {0, -half, 0, half}}, {"scale", {0.5, 0.5, 0.5}}},
      {{"mesh", 0}, {"translation", {-1, -2, -3}}}};
  expect_solid(read_glb(glb.file()), "nodes", kOrigin, 1e-4);
  // Mirrored twice: once by the node, once by its points.
  GlbBuilder mirrored = plain_glb();
  for (size_t i = 0; i < kPoints.size(); i++) mirrored.bytes[12 * i + 3] ^= '\x80';
  std::vector<int> turned = flat_faces();
  for (size_t i = 0; i < turned.size(); i += 3) std::swap(turned[i], turned[i + 1]);
  mirrored.json["meshes"][0]["primitives"][0]["indices"] = mirrored.indices<uint16_t>(turned, 5123);
  mirrored.json["nodes"][0]["scale"] = {-1, 1, 1};
  expect_solid(read_glb(mirrored.file()), "mirrored", kOrigin, kGlb);
  // Without scenes, all root nodes are read. If there are several scenes, the default one is read.
  GlbBuilder none = plain_glb();
  none.json.erase("scenes");
  none.json.erase("scene");
  none.json["nodes"] = {{{"mesh", 0}}, {{"name", "empty"}}};
  expect_solid(read_glb(none.file()), "no scene", kOrigin, kGlb);
  GlbBuilder two = plain_glb();
  two.json["nodes"].push_back({{"mesh", 0}, {"translation", {5, 5, 5}}});
  two.json["scenes"] = {{{"nodes", {1}}}, {{"nodes", {0}}}};
  two.json["scene"] = 1;
  Notes notes;
  expect_solid(read_glb(two.file(), &notes), "second scene", kOrigin, kGlb);
  EXPECT_EQ(notes.size(), 1u);
  // Many parts share one list of vertices. Only the vertices that are used are kept.
  GlbBuilder parts;
  const int points = parts.points();
  for (const auto& face : kFaces)
    parts.primitive(points, parts.indices<uint8_t>({face[0], face[1], face[2]}, 5121));
  const auto read = read_glb(parts.file());
  expect_solid(read, "parts", kOrigin, kGlb);
  EXPECT_EQ(read.value().vertices.size(), 60u);
}

TEST(GlbReader, ExtensionsAreNamed) {
  for (const char* harmless :
       {"KHR_materials_unlit", "KHR_texture_transform", "EXT_texture_webp"}) {
    GlbBuilder glb = plain_glb();
    glb.json["extensionsUsed"] = glb.json["extensionsRequired"] = {harmless};
    Notes notes;
    expect_solid(read_glb(glb.file(), &notes), harmless, kOrigin, kGlb);
    EXPECT_TRUE(notes.empty());
  }
  for (const char* other : {"EXT_mesh_gpu_instancing", "KHR_draco_mesh_compression",
                            "EXT_meshopt_compression", "MY_own_geometry", "CESIUM_RTC"}) {
    GlbBuilder glb = plain_glb();
    glb.json["extensionsUsed"] = glb.json["extensionsRequired"] = {other};
    expect_refused(read_glb(glb.file()), std::string("'") + other + "'");
    // If the extension is not required, the file is read without it.
    glb.json.erase("extensionsRequired");
    Notes notes;
    expect_solid(read_glb(glb.file(), &notes), other, kOrigin, kGlb);
  }
  // Compressed data without a fallback, although the extension is not listed as required.
  GlbBuilder draco = plain_glb();
  draco.json["accessors"][0].erase("bufferView");
  draco.json["meshes"][0]["primitives"][0]["extensions"] = {
      {"KHR_draco_mesh_compression", {{"bufferView", 0}}}};
  expect_refused(read_glb(draco.file()), "'KHR_draco_mesh_compression'");
  Json whole = plain_glb().json;
  whole["buffers"] = {
      {{"byteLength", 4}},
      {{"byteLength", 264}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  for (Json& view : whole["bufferViews"]) view["buffer"] = 1;
  expect_refused(read_glb(GlbBuilder::file_of(whole.dump(), "data")), "'EXT_meshopt_compression'");
  GlbBuilder copies = plain_glb();
  copies.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  copies.json["nodes"][0]["extensions"] = {{"EXT_mesh_gpu_instancing", Json::object()}};
  copies.json["nodes"][0]["skin"] = 0;
  copies.json["meshes"][0]["weights"] = {0.0, 0.5};
  Notes notes;
  expect_solid(read_glb(copies.file(), &notes), "notes", kOrigin, kGlb);
  EXPECT_EQ(notes.size(), 4u);
}

TEST(GlbReader, WrongFilesAreRefused) {
  const GlbBuilder good = plain_glb();
  const auto refused = [](const GlbBuilder& glb, const std::string& expected) {
    expect_refused(read_glb(glb.file()), expected);
  };
  const auto with = [&](const std::function<void(Json&)>& change) {
    GlbBuilder glb = good;
    change(glb.json);
    return glb;
  };
  expect_refused(read_glb(""), "is a GLB file");
  expect_refused(read_glb("glTF"), "cut short");
  std::string file = good.file();
  file[4] = 1;
  expect_refused(read_glb(file), "version 1 of glTF");
  expect_refused(read_glb(good.file().substr(0, good.file().size() - 20)), "cut short?");
  expect_refused(read_glb(std::string(200000, '[')), "is a GLB file");
  expect_refused(read_glb("{\"a\":" + std::string(200000, '[')), "levels deep");
  expect_refused(read_glb("{\"a\":" + std::string(90, '[')), "JSON is invalid");
  refused(with([](Json& j) { j["asset"]["version"] = "1.0"; }), "version '1.0'");
  refused(with([](Json& j) { j["nodes"][0]["mesh"] = 7; }), "number 7 of 'meshes'");
  refused(with([](Json& j) { j["nodes"][0]["mesh"] = -1; }), "node 0 has no 'mesh'");
  refused(with([](Json& j) { j["scenes"][0]["nodes"] = {0, 9}; }), "node 9 is referenced");
  refused(with([](Json& j) { j["nodes"][0]["children"] = {0}; }), "occurs twice");
  refused(with([](Json& j) { j["nodes"][0]["rotation"] = {1, 2}; }), "'rotation' is not 4 numbers");
  refused(with([](Json& j) { j["nodes"][0]["matrix"] = "x"; }), "'matrix' is not 16 numbers");
  refused(with([](Json& j) { j["nodes"][0]["scale"] = {1e308, 1e308, 1e308}; }), "part.glb");
  refused(with([](Json& j) { j["accessors"][0]["count"] = 13; }), "accessor 0 has 13 elements");
  refused(with([](Json& j) { j["accessors"][0]["count"] = 1e15; }), "accessor 0 has");
  refused(with([](Json& j) {
            j["accessors"][0].erase("bufferView");
            j["accessors"][0]["count"] = 4000000000u;
          }),
          "accessor 0 has");
  refused(with([](Json& j) { j["accessors"][0]["count"] = 11; }),
          "refers to vertex 11, but the number of vertices is 11");
  refused(with([](Json& j) { j["accessors"][0]["type"] = "VEC2"; }), "'VEC2' instead of VEC3");
  refused(with([](Json& j) { j["accessors"][0]["componentType"] = 5130; }), "type 5130");
  refused(with([](Json& j) { j["accessors"][1]["componentType"] = 5126; }), "accessor 1");
  refused(with([](Json& j) { j["accessors"][1]["count"] = 59; }), "not a multiple of three");
  refused(with([](Json& j) { j["bufferViews"][0]["byteStride"] = 8; }), "every 8 bytes");
  refused(with([](Json& j) { j["bufferViews"][1]["byteLength"] = 1e9; }),
          "bufferView 1 ends at byte");
  refused(with([](Json& j) { j["bufferViews"][0]["byteOffset"] = 9007199254740992.0; }),
          "bufferView 0 ends");
  refused(with([](Json& j) { j["meshes"][0]["primitives"][0]["mode"] = 7; }), "mode 7");
  refused(with([](Json& j) { j["meshes"][0]["primitives"][0]["mode"] = 0; }),
          "only points or lines");
  refused(with([](Json& j) { j["meshes"] = 3; }), "number 0 of 'meshes'");
  refused(with([](Json& j) { j["scenes"][0]["nodes"] = Json::array(); }), "no triangles");
  Json whole = good.json;
  for (const char* uri : {"other.bin", "../x", "file:///etc/passwd"}) {
    whole["buffers"] = {{{"byteLength", 264}, {"uri", uri}}};
    expect_refused(read_glb(GlbBuilder::file_of(whole.dump(), good.bytes)), "is in another file");
  }
  whole["buffers"] = {{{"byteLength", 264}, {"uri", "data:;base64,####"}}};
  expect_refused(read_glb(GlbBuilder::file_of(whole.dump(), good.bytes)), "not base64");
}

// --- glTF: text, and its bytes in other files

Json gltf_with(const Json& buffers) {
  Json json = plain_glb().json;
  json["buffers"] = buffers;
  return json;
}
// The points in one buffer and the corners in another.
std::pair<std::string, std::string> points_and_corners() {
  const std::string bytes = plain_glb().bytes;
  return {bytes.substr(0, 144), bytes.substr(144)};
}

TEST(GltfReader, DataInTheTextOrInFilesNextToIt) {
  const test::Folder folder;
  const std::string bytes = plain_glb().bytes;
  const auto write = [&](const std::string& name, const std::string& content) {
    std::ofstream(folder.path / name, std::ios::binary) << content;
    return folder.path / name;
  };
  const auto expect_read = [&](const Json& json, const std::string& what) {
    Notes notes;
    expect_solid(read_mesh(write("part.gltf", json.dump(2)), &notes), what, kOrigin, kGlb);
    EXPECT_TRUE(notes.empty()) << what;
  };
  expect_read(gltf_with({{{"byteLength", bytes.size()},
                          {"uri", "data:application/gltf-buffer;base64," + base64(bytes)}}}),
              "data URI");
  std::filesystem::create_directory(folder.path / "data");
  for (const auto& [uri, name] :
       std::vector<std::pair<std::string, std::string>>{{"part.bin", "part.bin"},
                                                        {"./part.bin", "part.bin"},
                                                        {"data/a.bin", "data/a.bin"},
                                                        {"data/%61.bin", "data/a.bin"},
                                                        {"my part.bin", "my part.bin"},
                                                        {"my%20part.bin", "my part.bin"},
                                                        {"100%.bin", "100%.bin"},
                                                        {"50%25.bin", "50%.bin"},
                                                        {"..bin", "..bin"},
                                                        {"gr\xc3\xb6\xc3\x9f"
                                                         "e.bin",
                                                         "gr\xc3\xb6\xc3\x9f"
                                                         "e.bin"},
                                                        {"gr%C3%b6%c3%9Fe.bin",
                                                         "gr\xc3\xb6\xc3\x9f"
                                                         "e.bin"},
                                                        {"without_ending", "without_ending"}}) {
    write(name, bytes);
    expect_read(gltf_with({{{"byteLength", bytes.size()}, {"uri", uri}}}), uri);
    std::filesystem::remove(folder.path / name);
  }
  // The first buffer is a file. The second one is another file, or is inside the JSON.
  const auto [points, corners] = points_and_corners();
  write("points.bin", points);
  write("corners.bin", corners);
  const std::string inside = "data:;base64," + base64(corners);
  for (const std::string& second : {std::string("corners.bin"), inside}) {
    Json json = gltf_with({{{"byteLength", points.size()}, {"uri", "points.bin"}},
                           {{"byteLength", corners.size()}, {"uri", second}}});
    json["bufferViews"][1]["buffer"] = 1;
    json["bufferViews"][1]["byteOffset"] = 0;
    // A file that no accessor needs may be missing.
    json["buffers"].push_back({{"byteLength", 4}, {"uri", "animation.bin"}});
    expect_read(json, second);
  }
  // A GLB file with the wrong ending.
  expect_solid(read_mesh(write("b.gltf", plain_glb().file())), "b.gltf", kOrigin, kGlb);
}

TEST(GltfReader, OtherFilesAreRefused) {
  const test::Folder folder;
  const std::string bytes = plain_glb().bytes;
  const auto write = [&](const std::filesystem::path& path, const std::string& content) {
    std::ofstream(path, std::ios::binary) << content;
    return path;
  };
  const std::filesystem::path inner = folder.path / "inner";
  std::filesystem::create_directories(inner / "sub");
  const std::filesystem::path secret = write(folder.path / "secret.bin", bytes);
  write(inner / "sub" / "a.bin", bytes);
  std::filesystem::create_symlink(secret, inner / "link.bin");
  std::filesystem::create_symlink("sub/a.bin", inner / "good.bin");
  ASSERT_EQ(mkfifo((inner / "pipe.bin").c_str(), 0600), 0);
  const auto refused = [](const Result<TriangleMesh>& read, const std::string& expected) {
    ASSERT_FALSE(read.ok()) << expected;
    EXPECT_NE(read.error().find(expected), std::string::npos) << read.error();
    EXPECT_EQ(read.error().find('\n'), std::string::npos) << read.error();
  };
  const auto expect_end = [&](const std::string& uri, const std::string& expected) {
    const Json json = gltf_with({{{"byteLength", bytes.size()}, {"uri", uri}}});
    const auto read = read_mesh(write(inner / "part.gltf", json.dump()));
    refused(read, expected);
    if (read.ok()) return;
    EXPECT_NE(read.error().find("part.gltf: buffer 0 is in"), std::string::npos) << read.error();
    EXPECT_NE(read.error().find("save all as one GLB file (.glb)"), std::string::npos);
  };
  const std::string outside = "outside of the file's folder";
  expect_end(secret.string(), outside);
  expect_end("../secret.bin", outside);
  expect_end("sub/../../secret.bin", outside);
  expect_end("sub/../sub/a.bin", outside);
  expect_end("%2e%2e/secret.bin", outside);
  expect_end("%2E.%2Fsecret.bin", outside);
  expect_end("..\\secret.bin", outside);
  expect_end("C:\\part.bin", outside);
  expect_end("\\\\host\\part.bin", outside);
  expect_end("link.bin", outside);
  expect_end("..", outside);
  for (const std::string scheme : {"http://", "https://", "file://", "file:", "ftp://"})
    expect_end(scheme + secret.string(), "does not load web addresses");
  expect_end("missing.bin", "which does not exist; put it next to the file");
  expect_end("sub", "no file that can be read");
  expect_end("pipe.bin", "no file that can be read");
  expect_end("", "not the name of a file");
  expect_end("a%00.bin", "not the name of a file");
  // A link inside the folder is read.
  Json json = gltf_with({{{"byteLength", bytes.size()}, {"uri", "good.bin"}}});
  expect_solid(read_mesh(write(inner / "part.gltf", json.dump())), "link", kOrigin, kGlb);
  // A file that is too short is checked like a chunk.
  write(inner / "short.bin", bytes.substr(0, 200));
  json = gltf_with({{{"byteLength", bytes.size()}, {"uri", "short.bin"}}});
  refused(read_mesh(write(inner / "part.gltf", json.dump())), "bufferView 1 ends at byte");
  // A .glb file reads no other file, even one next to it.
  json = gltf_with({{{"byteLength", bytes.size()}, {"uri", "good.bin"}}});
  refused(read_mesh(write(inner / "part.glb", json.dump())), "is in another file");
  refused(read_mesh(write(inner / "part.gltf", "{\"buffers\":[")), "JSON is invalid");
}

TEST(MeshReaders, BrokenFilesAreRefusedOrSound) {
  torment(ascii_stl(), [](const std::string& b, Notes* n) { return parse_stl(b, "a", n); });
  torment(binary_stl("x", 3), [](const std::string& b, Notes* n) { return parse_stl(b, "a", n); });
  const Parse obj_parser = [](const std::string& b, Notes* n) { return parse_obj(b, "a", n); };
  torment(obj(), obj_parser);
  torment(obj_faces(kPolygons, plain_index) + obj_points(), obj_parser);
  torment("OFF\n12 8 0\n" + off_points() + off_faces(kPolygons),
          [](const std::string& b, Notes* n) { return parse_off(b, "a", n); });
  torment(ply_head("ascii", "fcv") + ply_body("fcv"),
          [](const std::string& b, Notes* n) { return parse_ply(b, "a", n); });
  const Parse glb_parser = [](const std::string& b, Notes* n) { return parse_glb(b, "a", n); };
  torment(plain_glb().file(), glb_parser);
  torment(quantized<int16_t>(5122, true, 100).file(), glb_parser);
  const GltfFiles files = [] {
    const std::string bytes = plain_glb().bytes;
    GltfFiles made;
    made.emplace("part.bin", std::vector<char>(bytes.begin(), bytes.end()));
    return made;
  }();
  torment(gltf_with({{{"byteLength", 264}, {"uri", "part.bin"}}}).dump(),
          [&](const std::string& b, Notes* n) { return parse_glb(b, "a", n, &files); });
}

// Reads through the helper program, as Kibori does. The solid and the notes about omissions arrive.
TEST(MeshReaders, NotesPassTheHelper) {
  const test::Folder folder;
  const auto write = [&](const std::string& name, const std::string& bytes) {
    std::ofstream(folder.path / name, std::ios::binary) << bytes;
    return folder.path / name;
  };
  Notes notes;
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"a.obj", obj() + "p 1\n"},
           {"b.off", "OFF\n12 20 0\n" + off_points() + off_faces(kFaces) + "1 0\n"},
           {"c.ply", ply_head() + ply_body() + "7\n"},
           {"d.stl", binary_stl() + "xy"}}) {
    notes.clear();
    expect_solid(read_mesh(write(name, bytes), &notes), name);
    ASSERT_EQ(notes.size(), 1u) << name;
    EXPECT_NE(notes[0].find(name + ":"), std::string::npos) << notes[0];
    expect_solid(read_mesh(folder.path / name), name);
  }
  notes.clear();
  expect_solid(read_mesh(write("e.GLB", plain_glb().file()), &notes), "e.GLB", kOrigin, kGlb);
  EXPECT_TRUE(notes.empty());
}

// --- polygons

// The area that triangles cover, each with a positive sign. It exceeds the polygon's if they
// overlap.
double covered_area(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += (mesh.vertices[t[1]] - mesh.vertices[t[0]])
               .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
               .norm() /
           2;
  return sum;
}

// The triangles of a random star-shaped polygon in a random plane cover its area once.
TEST(Polygons, ConcaveOnesAreCutIntoTrianglesInside) {
  Random random;
  for (int round = 0; round < 300; round++) {
    const int count = random.integer(4, 60);
    const Mat3 turn =
        rotation(Vec3(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)));
    TriangleMesh mesh;
    std::vector<uint32_t> corners;
    double area = 0;  // by the shoelace formula
    std::vector<Vec3> flat;
    for (int i = 0; i < count; i++) {
      const double angle = 2 * std::numbers::pi * i / count, r = random.uniform(1, 10);
      flat.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
      mesh.vertices.push_back(turn * flat.back() + Vec3(5, -7, 2));
      corners.push_back(static_cast<uint32_t>(i));
    }
    for (size_t i = 0; i < flat.size(); i++)
      area += flat[i].cross(flat[(i + 1) % flat.size()]).z() / 2;
    Polygons polygons;
    polygons.add(mesh, corners);
    polygons.finish(mesh);
    ASSERT_EQ(mesh.triangles.size(), corners.size() - 2);
    EXPECT_NEAR(covered_area(mesh), area, 1e-9 * area) << count << " corners; " << random.note();
  }
}

// Crescents, whose ears need many tests. One large face, and many small ones.
TEST(Polygons, LongCrescentsAreCutCompletely) {
  for (const auto& [half, count] : {std::pair{2500, 1}, {250, 40}}) {
    TriangleMesh mesh;
    Polygons polygons;
    double area = 0;
    for (int face = 0; face < count; face++) {
      std::vector<uint32_t> corners;
      std::vector<Vec3> flat;
      for (int i = 0; i < 2 * half; i++) {
        const bool inner = i >= half;
        const double angle = std::numbers::pi * (inner ? 2 * half - 1 - i : i) / (half - 1);
        const double r = inner ? 9 - 0.5 * std::sin(angle) : 10;
        flat.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
        corners.push_back(static_cast<uint32_t>(mesh.vertices.size()));
        mesh.vertices.push_back(flat.back());
      }
      for (size_t i = 0; i < flat.size(); i++)
        area += flat[i].cross(flat[(i + 1) % flat.size()]).z() / 2;
      polygons.add(mesh, corners);
    }
    polygons.finish(mesh);
    EXPECT_NEAR(covered_area(mesh), area, 1e-9 * area) << 2 * half << " corners";
  }
}

TEST(Polygons, HolesByABridge) {
  // A square with a square hole; corners 0 and 4 have two places in the face, as exporters write
  // it.
  TriangleMesh mesh;
  for (const auto& [x, y] : std::vector<std::pair<double, double>>{
           {0, 0}, {9, 0}, {9, 9}, {0, 9}, {3, 3}, {3, 6}, {6, 6}, {6, 3}})
    mesh.vertices.emplace_back(x, y, 1);
  Polygons polygons;
  polygons.add(mesh, std::vector<uint32_t>{0, 1, 2, 3, 0, 4, 5, 6, 7, 4});
  polygons.finish(mesh);
  EXPECT_NEAR(covered_area(mesh), 81 - 9, 1e-9);
}

TEST(MeshText, WordsLinesAndNumbers) {
  EXPECT_EQ(parse_number("1e-400"), 0.0);
  EXPECT_EQ(parse_number("-.5"), -0.5);
  EXPECT_EQ(parse_number("+5."), 5.0);
  for (const char* wrong : {"", "+", "-", ".", "1e400", "nan", "inf", "1 ", "1d3", "+-1"})
    EXPECT_FALSE(parse_number(wrong)) << wrong;
  EXPECT_EQ(in_quotes(std::string(39, 'x') + "\xc3\xb6z"), "'" + std::string(39, 'x') + "...'");
  Lines lines("a\rb\r\n\nc");
  std::string_view line;
  std::string all;
  while (lines.next(line)) all += std::to_string(lines.number()) + std::string(line) + ";";
  EXPECT_EQ(all, "1a;2b;3;4c;");
}

}  // namespace
}  // namespace kibori::mesh_readers_tests
