// SPDX-License-Identifier: MIT
// Files out and in: round trips, limits, hostile bytes, and a helper program that misbehaves.
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <png.h>
#include <unistd.h>

#include <kibori/base/file.h>
#include <kibori/edit/edit.h>
#include <kibori/formats/import_helper.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/formats/png_file.h>
#include <kibori/formats/stl.h>
#include <kibori/formats/surface_file.h>
#include <kibori/formats/threemf.h>
#include <kibori/formats/zip.h>
#include <kibori/solid/ball.h>
#include <kibori/surface/surface.h>

#include "tests/support.h"

namespace kibori::files_tests {
namespace {

using test::Random;

class Folder {
 public:
  Folder()
      : path_(std::filesystem::temp_directory_path() /
              ("kibori-files-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

// A written file reads back: the same corners to the bit, triangle by triangle. A file that welds
// by position has the same vertices again.
TEST(SurfaceFile, RoundTripsThroughEveryFormat) {
  Lattice lattice;
  lattice.nodes = Index3(30, 25, 20);
  lattice.pitch_mm = 0.37;
  lattice.origin_mm = Vec3(-3, 100, 7);
  TriDexel model(lattice);
  model.fill_block(
      {lattice.to_mm(LatticePoint{Vec3(2, 2, 2)}), lattice.to_mm(LatticePoint{Vec3(28, 22, 17)})},
      0);
  Removed removed;
  cut(model, SweptBall(LatticePoint{Vec3(5, 12, 18)}, LatticeVector{Vec3(20, 3, -2)}, 5), {},
      removed);
  const Surface surface = extract_surface(model.snapshot());
  const SurfaceSource whole = [&](const SurfaceSink& sink) {
    stream_surface(model.snapshot(), 2, sink);
  };
  const Rgb oak{196, 154, 108};
  const Folder folder;
  for (const std::string_view ending : kMeshesWritten) {
    const std::string name = ending == ".ply" ? "a.PLY" : "a" + std::string(ending);
    const bool exact = name != "a.glb";  // the conversion to metres rounds once more
    ASSERT_TRUE(write_surface(folder / name, whole, {&oak, 1}).ok()) << name;
    const Result<TriangleMesh> back = read_mesh(folder / name);
    ASSERT_TRUE(back.ok()) << name << " " << back.error();
    const TriangleMesh& mesh = back.value();
    ASSERT_EQ(mesh.triangles.size(), surface.triangles.size()) << name;
    std::set<std::array<double, 3>> places;
    for (size_t t = 0; t < mesh.triangles.size(); t++)
      for (size_t i = 0; i < 3; i++) {
        const Vec3& p = mesh.vertices[mesh.triangles[t][i]];
        const auto& q = surface.vertices[surface.triangles[t][i]].position;
        for (int k = 0; k < 3; k++) {
          const double wanted = static_cast<double>(q[static_cast<size_t>(k)]);
          if (exact)
            ASSERT_EQ(static_cast<float>(p[k]), q[static_cast<size_t>(k)]) << name;
          else
            ASSERT_NEAR(p[k], wanted, 2e-5) << name;
        }
        places.insert({p[0], p[1], p[2]});
      }
    if (exact) {
      EXPECT_EQ(places.size(), surface.vertices.size()) << name;
    }
  }
  EXPECT_FALSE(write_surface(folder / "a.xyz", whole, {}).ok());
  EXPECT_FALSE(write_surface(folder / "no" / "a.stl", whole, {}).ok());
  EXPECT_FALSE(write_surface(folder.path(), whole, {}).ok());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()),
                          std::filesystem::directory_iterator()),
            std::ssize(kMeshesWritten));
}

// Several objects keep their positions, and their names if the format has names.
TEST(SurfaceFile, ObjectsKeepTheirPoses) {
  Lattice lattice;
  lattice.nodes = Index3(24, 20, 16);
  lattice.pitch_mm = 0.5;
  TriDexel block(lattice), ball(lattice), nothing(lattice);
  block.fill_block({Vec3(1, 1, 1), Vec3(11, 9, 7)}, 0);
  Removed added;
  deposit(ball, SweptBall(LatticePoint{Vec3(12, 10, 8)}, LatticeVector{Vec3(1, 0, 0)}, 5), 1, {},
          added);
  const auto source = [](const TriDexel& model) {
    return [state = model.snapshot()](const SurfaceSink& sink) { stream_surface(state, 2, sink); };
  };
  const Pose there{Vec3(30, -7, 4), rotation(Vec3(0.4, -0.7, 1.1))};
  const std::vector<SurfaceObject> objects{{"Lid <\"A&B\">", {}, source(block)},
                                           {"nothing", {}, source(nothing)},
                                           {"Knauf \xc3\xb6", there, source(ball)}};
  const std::vector<Rgb> colors{{196, 154, 108}, {40, 90, 200}};
  std::vector<Vec3> wanted;
  size_t triangles = 0;
  for (const auto& [model, pose] : {std::pair{&block, Pose()}, {&ball, there}}) {
    const Surface surface = extract_surface(model->snapshot());
    triangles += surface.triangles.size();
    for (const SurfaceTriangle& t : surface.triangles)
      for (const uint32_t corner : t) {
        const auto& p = surface.vertices[corner].position;
        wanted.push_back(pose.to_world(Vec3(p[0], p[1], p[2])));
      }
  }
  const Folder folder;
  for (const char* name : {"a.stl", "a.ply", "a.obj", "a.3mf", "a.glb"}) {
    const Status written = write_objects(folder / name, objects, colors);
    ASSERT_TRUE(written.ok()) << name << written.error();
    const Result<TriangleMesh> back = read_mesh(folder / name);
    ASSERT_TRUE(back.ok()) << name << " " << back.error();
    const TriangleMesh& mesh = back.value();
    ASSERT_EQ(mesh.triangles.size(), triangles) << name;
    double far = 0;
    for (size_t i = 0; i < wanted.size(); i++)
      far = std::max(far, Vec3(mesh.vertices[mesh.triangles[i / 3][i % 3]] - wanted[i]).norm());
    EXPECT_LT(far, 2e-5) << name;
    std::ifstream in(folder / name, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (std::string(name) == "a.obj") {
      EXPECT_NE(bytes.find("\no Lid_<\"A&B\">\n"), std::string::npos);
    }
    if (std::string(name) == "a.glb") {
      EXPECT_NE(bytes.find("Knauf \xc3\xb6"), std::string::npos);
      EXPECT_EQ(bytes.find("nothing"), std::string::npos);
    }
  }
  const std::vector<SurfaceObject> none{objects[1]};
  EXPECT_FALSE(write_objects(folder / "b.3mf", none, colors).ok());
  EXPECT_FALSE(std::filesystem::exists(folder / "b.3mf"));
}

// A handwritten cube of 10 mm as 3MF. `model`: replaces the whole model part.
std::string model_part(const std::string& more = "", const std::string& head = "") {
  std::string text = "<?xml version=\"1.0\"?>" + head +
                     "<model unit=\"centimeter\" "
                     "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">"
                     "<resources><object id=\"1\"><mesh><vertices>";
  for (int i = 0; i < 8; i++)
    text += "<vertex x=\"" + std::to_string(i & 1) + "\" y=\"" + std::to_string(i >> 1 & 1) +
            "\" z=\"" + std::to_string(i >> 2) + "\"/>";
  text += "</vertices><triangles>";
  for (const auto& t : {"0 2 1", "1 2 3", "4 5 6", "5 7 6", "0 1 4", "1 5 4", "2 6 3", "3 6 7",
                        "0 4 2", "2 4 6", "1 3 5", "3 7 5"}) {
    int a, b, c;
    std::sscanf(t, "%d %d %d", &a, &b, &c);
    text += "<triangle v1=\"" + std::to_string(a) + "\" v2=\"" + std::to_string(b) + "\" v3=\"" +
            std::to_string(c) + "\"/>";
  }
  return text + "</triangles></mesh></object>" + more +
         "</resources><build><item objectid=\"1\"/></build></model>";
}
std::string archive(const Folder& folder,
                    const std::vector<std::pair<std::string, std::string>>& entries) {
  NewFile file(folder / "a.zip");
  ZipWriter zip(file);
  for (const auto& [name, content] : entries) {
    zip.begin(name);
    zip.write(content);
    zip.end();
  }
  EXPECT_TRUE(zip.finish().ok());
  EXPECT_TRUE(file.commit().ok());
  const auto bytes = read_file(folder / "a.zip").value();
  return {bytes.begin(), bytes.end()};
}
std::string with_model(const Folder& folder, const std::string& model) {
  return archive(folder, {{"3D/3dmodel.model", model}});
}
std::string replaced(std::string text, const std::string& old, const std::string& fresh) {
  const size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return at == std::string::npos ? text : text.replace(at, old.size(), fresh);
}
constexpr const char* kItem = "<item objectid=\"1\"/>";
double volume_of(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
  return sum;
}

TEST(ThreeMf, UnitsTransformsAndComponents) {
  const Folder folder;
  auto mesh = parse_3mf(with_model(folder, model_part()), "a");
  ASSERT_TRUE(mesh.ok()) << mesh.error();
  EXPECT_NEAR(volume_of(mesh.value()), 1000, 1e-9);
  // Twice in another object, once mirrored; that object twice as large and moved in the build.
  std::string text = model_part(
      "<object id=\"2\"><components><component objectid=\"1\"/>"
      "<component objectid=\"1\" transform=\"-1 0 0  0 1 0  0 0 1  5 0 "
      "0\"/></components></object>");
  text = replaced(text, kItem, "<item objectid=\"2\" transform=\"2 0 0 0 2 0 0 0 2 1 2 3\"/>");
  mesh = parse_3mf(with_model(folder, text), "a");
  ASSERT_TRUE(mesh.ok()) << mesh.error();
  EXPECT_NEAR(volume_of(mesh.value()), 2 * 8000, 1e-9);
  const Box box = mesh.value().bounds();
  EXPECT_NEAR((box.min - Vec3(10, 20, 30)).norm(), 0, 1e-9);
  EXPECT_NEAR((box.max - Vec3(110, 40, 50)).norm(), 0, 1e-9);
}

// Notes name the parts of a file that are left out. Errors name forbidden parts.
TEST(ThreeMf, SlicersPartsAndExtensions) {
  const Folder folder;
  std::vector<std::string> notes;
  const auto read = [&](const std::string& model,
                        std::vector<std::pair<std::string, std::string>> more = {}) {
    notes.clear();
    more.emplace_back("3D/3dmodel.model", model);
    return parse_3mf(archive(folder, more), "a.3mf", &notes);
  };
  const auto expected = [&](const std::string& what) {
    return std::ranges::any_of(notes, [&](const std::string& note) {
      return note.find("a.3mf: ") == 0 && note.find(what) != std::string::npos;
    });
  };
  const std::string plain = model_part();
  ASSERT_TRUE(read(plain).ok());
  EXPECT_TRUE(notes.empty()) << notes[0];
  // PrusaSlicer: triangles 0 to 11 are the solid, the next two belong to something else.
  const std::string two = replaced(plain, "</triangles>",
                                   "<triangle v1=\"0\" v2=\"3\" v3=\"7\"/><triangle v1=\"0\" "
                                   "v2=\"7\" v3=\"3\"/></triangles>");
  const auto config = [](const std::string& kind) {
    return "<config><object id=\"1\"><volume firstid=\"0\" lastid=\"11\"><metadata "
           "key=\"volume_type\""
           " value=\"ModelPart\"/></volume><volume firstid=\"12\" lastid=\"13\"><metadata "
           "type=\"volume\" " +
           kind + "/></volume></object></config>";
  };
  for (const char* kind : {"ParameterModifier", "SupportBlocker", "SupportEnforcer"}) {
    const auto mesh =
        read(two, {{"Metadata/Slic3r_PE_model.config",
                    config("key=\"volume_type\" value=\"" + std::string(kind) + "\"")}});
    ASSERT_TRUE(mesh.ok()) << mesh.error();
    EXPECT_EQ(mesh.value().triangles.size(), 12u);
    EXPECT_TRUE(expected("'" + std::string(kind) + "'"));
  }
  EXPECT_EQ(read(two, {{"Metadata/Slic3r_PE_model.config", config("key=\"modifier\" value=\"1\"")}})
                .value()
                .triangles.size(),
            12u);
  EXPECT_EQ(read(two, {{"Metadata/Slic3r_PE_model.config",
                        config("key=\"volume_type\" value=\"NegativeVolume\"")}})
                .value()
                .triangles.size(),
            12u);
  EXPECT_TRUE(expected("negative part"));
  EXPECT_EQ(read(two, {{"Metadata/Slic3r_PE_model.config", "<config"}}).value().triangles.size(),
            14u);
  EXPECT_TRUE(expected("is not valid XML"));
  // Files of Bambu Studio, whose parts are components.
  const std::string parts = replaced(
      model_part("<object id=\"2\"><components><component objectid=\"1\"/></components></object>"
                 "<object id=\"3\"><components><component objectid=\"1\"/><component "
                 "objectid=\"2\"/></components></object>"),
      kItem, "<item objectid=\"3\"/>");
  EXPECT_EQ(read(parts).value().triangles.size(), 24u);
  for (const char* kind : {"modifier_part", "negative_part", "support_blocker"}) {
    EXPECT_EQ(
        read(parts, {{"Metadata/model_settings.config",
                      "<config><object id=\"3\"><part id=\"1\" subtype=\"normal_part\"/><part "
                      "id=\"2\" subtype=\"" +
                          std::string(kind) + "\"/></object></config>"}})
            .value()
            .triangles.size(),
        12u);
    EXPECT_EQ(notes.size(), 1u);
  }
  // The error names each required extension that Kibori does not support.
  const auto requires_one = [&](const std::string& name, const std::string& space) {
    return read(replaced(plain, "<model ",
                         "<model xmlns:q=\"http://schemas.microsoft.com/" + space +
                             "\" requiredextensions=\"" + name + "\" "));
  };
  EXPECT_TRUE(requires_one("q", "3dmanufacturing/production/2015/06").ok());
  EXPECT_TRUE(requires_one("q", "3dmanufacturing/material/2015/02").ok());
  for (const char* space : {"3dmanufacturing/beamlattice/2017/02", "x"}) {
    const auto refused = requires_one("q", space);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().find("'q' (http://schemas.microsoft.com/" + std::string(space)),
              std::string::npos)
        << refused.error();
  }
  EXPECT_FALSE(requires_one("z", "3dmanufacturing/production/2015/06").ok());
  // A note names an unknown element of a mesh.
  ASSERT_TRUE(read(replaced(plain, "</mesh>", "<beamlattice/></mesh>")).ok());
  EXPECT_TRUE(expected("'beamlattice'"));
  ASSERT_TRUE(
      read(replaced(plain, "<object id=\"1\"", "<basematerials id=\"1\"/><object id=\"1\"")).ok());
  EXPECT_TRUE(expected("two resources have the id '1'"));
  ASSERT_TRUE(read(replaced(plain, "<object id=\"1\"", "<object type=\"odd\" id=\"1\"")).ok());
  EXPECT_TRUE(expected("'odd'"));
}

// The directory has sizes of 64 bits. Programs that stream an archive write these.
TEST(ThreeMf, ArchivesWithSixtyFourBitSizes) {
  const Folder folder;
  const std::string small = with_model(folder, model_part());
  const auto number = [](uint64_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; i++) text += static_cast<char>(value >> (8 * i));
    return text;
  };
  const auto at = [&](size_t place) {
    uint64_t value = 0;
    for (size_t i = 4; i > 0; i--)
      value = value << 8 | static_cast<unsigned char>(small[place + i - 1]);
    return value;
  };
  const size_t end = small.size() - 22, central = at(end + 16);
  const std::string extra = "\x55\x55" + number(2, 2) + "xy" + number(1, 2) + number(24, 2) +
                            number(at(central + 24), 8) + number(at(central + 20), 8) +
                            number(at(central + 42), 8);
  std::string entry = small.substr(central, end - central);
  const std::string ones(4, '\xff');
  entry.replace(20, 8, ones + ones).replace(42, 4, ones).replace(30, 2, number(extra.size(), 2));
  entry += extra;
  const std::string record = "PK\6\6" + number(44, 8) + number(45, 2) + number(45, 2) +
                             number(0, 8) + number(1, 8) + number(1, 8) + number(entry.size(), 8) +
                             number(central, 8);
  const std::string locator =
      "PK\6\7" + number(0, 4) + number(central + entry.size(), 8) + number(1, 4);
  std::string last = small.substr(end);
  last.replace(8, 12, std::string(12, '\xff'));
  const std::string large = small.substr(0, central) + entry + record + locator + last;
  const auto mesh = parse_3mf(large, "a");
  ASSERT_TRUE(mesh.ok()) << mesh.error();
  EXPECT_NEAR(volume_of(mesh.value()), 1000, 1e-9);
  for (size_t size = central; size < large.size(); size++)
    EXPECT_FALSE(parse_3mf(large.substr(0, size), "a").ok());
  std::string lying = large;
  lying.replace(central + entry.size() + 48, 8, number(uint64_t{1} << 62, 8));
  EXPECT_FALSE(parse_3mf(lying, "a").ok());
}

TEST(ThreeMf, HostileArchivesAreRefused) {
  const Folder folder;
  const auto refused = [&](const std::string& bytes, const std::string& expected) {
    const auto mesh = parse_3mf(bytes, "a.3mf");
    ASSERT_FALSE(mesh.ok()) << expected;
    EXPECT_NE(mesh.error().find(expected), std::string::npos) << mesh.error();
    EXPECT_EQ(mesh.error().find("a.3mf: "), 0u) << mesh.error();
  };
  refused("", "not a ZIP");
  refused("PK", "not a ZIP");
  refused(with_model(folder, std::string(200 << 20, ' ')), "times its size");  // a bomb
  refused(archive(folder, {{"../3dmodel.model", "x"}}), "points outside");
  refused(archive(folder, {{"/etc/passwd", "x"}}), "points outside");
  refused(archive(folder, {{"readme.txt", "x"}}), "3D/3dmodel.model");
  refused(
      with_model(
          folder,
          model_part("", "<!DOCTYPE model [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;\">]>")),
      "document type");
  refused(with_model(folder, "<model"), "XML");
  refused(with_model(folder, model_part("<object id=\"1\"/>")), "two objects");
  std::string text = replaced(model_part(), "v1=\"0\"", "v1=\"9\"");
  refused(with_model(folder, text), "missing vertex");
  text = replaced(model_part(), "x=\"1\"", "x=\"1e999\"");
  refused(with_model(folder, text), "not a number");
  text = replaced(model_part(), "centimeter", "furlong");
  refused(with_model(folder, text), "furlong");
  // Infinite recursion of components; and a bomb: 10 in each of 30 levels.
  text =
      model_part("<object id=\"2\"><components><component objectid=\"2\"/></components></object>");
  text = replaced(text, kItem, "<item objectid=\"2\"/>");
  refused(with_model(folder, text), "contain themselves");
  std::string levels;
  for (int i = 2; i < 32; i++) {
    levels += "<object id=\"" + std::to_string(i) + "\"><components>";
    for (int k = 0; k < 10; k++)
      levels += "<component objectid=\"" + std::to_string(i - 1) + "\"/>";
    levels += "</components></object>";
  }
  text = model_part(levels);
  text = replaced(text, kItem, "<item objectid=\"31\"/>");
  refused(with_model(folder, text), "too many objects");
}

// Parses prefixes of a file, and files with flipped bits: a result or an error, no crash.
template <class Parse>
void torment(const std::string& bytes, Parse&& parse) {
  Random random;
  const size_t step = std::max<size_t>(1, bytes.size() / 600);
  for (size_t size = 0; size < bytes.size(); size += step) parse(bytes.substr(0, size));
  for (int i = 0; i < 3000; i++) {
    std::string broken = bytes;
    for (int k = random.integer(1, 4); k > 0; k--)
      broken[static_cast<size_t>(random.integer(0, static_cast<int>(bytes.size()) - 1))] ^=
          static_cast<char>(1 << random.integer(0, 7));
    parse(broken);
  }
}
TEST(Hostile, ThreeMf) {
  const Folder folder;
  torment(with_model(folder, model_part()), [](const std::string& bytes) {
    const auto mesh = parse_3mf(bytes, "a");
    EXPECT_TRUE(mesh.ok() || !mesh.error().empty());
  });
}
// Chunks about the brightness on a screen change no height, with alpha and in colour pictures.
TEST(PngFile, ColorSpacesChangeNothing) {
  const auto bytes_of = [](bool color, int chunk) {
    std::string out;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(
        png, &out,
        [](png_structp writer, png_bytep data, png_size_t size) {
          static_cast<std::string*>(png_get_io_ptr(writer))
              ->append(reinterpret_cast<const char*>(data), size);
        },
        [](png_structp) {});
    png_set_IHDR(png, info, 4, 1, 8, color ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_GRAY_ALPHA,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (chunk == 1) png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (chunk == 2) png_set_gAMA(png, info, 0.45455);
    if (chunk == 3) png_set_gAMA(png, info, 1);
    png_write_info(png, info);
    std::vector<png_byte> row;
    for (int x = 0; x < 4; x++) {
      for (int c = 0; c < (color ? 3 : 1); c++)
        row.push_back(static_cast<png_byte>(60 * x + 20 + 5 * c));
      row.push_back(static_cast<png_byte>(x % 2 ? 128 : 255));
    }
    png_write_row(png, row.data());
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return out;
  };
  for (const bool color : {false, true}) {
    const std::string plain = bytes_of(color, 0);
    const auto wanted = parse_png_grey({plain.data(), plain.size()}, "a");
    ASSERT_TRUE(wanted) << wanted.error();
    if (!color) {
      EXPECT_NEAR(wanted.value().pixels[1], 80 * 257 * 128 / 255.0, 60);
    }
    for (const int chunk : {1, 2, 3}) {
      const std::string bytes = bytes_of(color, chunk);
      const auto map = parse_png_grey({bytes.data(), bytes.size()}, "a");
      ASSERT_TRUE(map) << map.error();
      EXPECT_EQ(map.value().pixels, wanted.value().pixels) << color << " " << chunk;
    }
  }
}

TEST(Hostile, Png) {
  const Folder folder;
  std::vector<uint16_t> pixels(32 * 20);
  for (size_t i = 0; i < pixels.size(); i++) pixels[i] = static_cast<uint16_t>(i * 97);
  ASSERT_TRUE(write_png_grey16(folder / "a.png", 32, 20, pixels).ok());
  const auto bytes = read_file(folder / "a.png").value();
  const auto same = parse_png_grey(bytes, "a");
  ASSERT_TRUE(same.ok());
  EXPECT_EQ(same.value().pixels, pixels);
  EXPECT_EQ(same.value().width, 32);
  torment({bytes.begin(), bytes.end()}, [](const std::string& b) {
    const auto map = parse_png_grey(b, "a");
    EXPECT_TRUE(map.ok() || !map.error().empty());
  });
}
TEST(Hostile, Stl) {
  std::string bytes(84, '\0');
  bytes[80] = 40;
  bytes.resize(84 + 40 * 50, 'a');
  torment(bytes,
          [](const std::string& b) { EXPECT_FALSE(parse_stl(b, "a").ok() && b.size() < 84); });
}

// These tests replace the helper program by a shell script. Each failure of the helper must become
// an error message of one sentence.
class HelperTest : public ::testing::Test {
 protected:
  void TearDown() override { unsetenv("KIBORI_IMPORT"); }
  // Reads a file with this shell script as the helper.
  std::string message_of(const std::string& script) {
    const auto program = folder_.write("helper", "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    setenv("KIBORI_IMPORT", program.c_str(), 1);
    folder_.write("a.obj", "v 0 0 0\n");
    const auto mesh = read_mesh(folder_ / "a.obj");
    return mesh.ok() ? "read" : mesh.error();
  }
  Folder folder_;
};
TEST_F(HelperTest, CrashesAndNonsenseAreOneSentence) {
  EXPECT_NE(message_of("kill -SEGV $$").find("crashes the importer"), std::string::npos);
  EXPECT_NE(message_of("kill -KILL $$").find("too long or too much"), std::string::npos);
  EXPECT_NE(message_of("echo 'a.obj: is odd' >&2; echo more >&2; exit 2").find("a.obj: is odd"),
            std::string::npos);
  EXPECT_NE(message_of("exit 0").find("invalid mesh"), std::string::npos);
  EXPECT_NE(message_of("echo KIBMESH1 >&3").find("invalid mesh"), std::string::npos);
  // A header that promises 2^60 vertices, and one with an index out of range.
  EXPECT_NE(message_of("printf 'KIBMESH1\\0\\0\\0\\0\\0\\0\\0\\020\\1\\0\\0\\0\\0\\0\\0\\0' >&3")
                .find("million triangles"),
            std::string::npos);
  EXPECT_NE(
      message_of("(printf 'KIBMESH1\\0\\0\\0\\0\\0\\0\\0\\0\\1\\0\\0\\0\\0\\0\\0\\0'; head -c 12 "
                 "/dev/zero) >&3")
          .find("invalid mesh"),
      std::string::npos);
  EXPECT_NE(message_of("head -c 300000 /dev/zero | tr '\\0' 'x' >&2; exit 2").find("xxx"),
            std::string::npos);
  setenv("KIBORI_IMPORT", "/no/such/program", 1);
  EXPECT_NE(read_mesh(folder_ / "a.obj").error().find("does not start"), std::string::npos);
}
TEST_F(HelperTest, HostileFilesOfOtherFormats) {
  // Wrong counts, invalid text, and garbage: each is refused, and quickly.
  const auto refused = [&](const std::string& name, const std::string& bytes) {
    const auto mesh = read_mesh(folder_.write(name, bytes));
    ASSERT_FALSE(mesh.ok()) << name;
    EXPECT_NE(mesh.error().find(name), std::string::npos) << mesh.error();
    EXPECT_EQ(mesh.error().find('\n'), std::string::npos);
  };
  refused("a.ply",
          "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float "
          "x\nend_header\n");
  refused("b.ply", "ply\nformat ascii 1.0\n");
  refused("c.obj", "f 1 2 3\n");
  refused("d.glb", std::string("glTF\2\0\0\0\xff\xff\xff\x7f", 12));
  refused("e.glb", "not at all");
  refused("f.off", "OFF\n1000000000 1000000000 0\n");
  refused("g.3mf", "PK\3\4");
  refused("h.obj", std::string(100000, '\xff'));
}
// A confined process tries to open files and sockets, and to start a program. Each attempt is
// refused, and the process continues.
TEST(Confined, OpensAndStartsNothing) {
#ifdef KIBORI_SANITIZED
  GTEST_SKIP() << "sanitisers open files themselves";
#endif
  Folder folder;
  const std::string canary = folder.write("canary", "a secret").string();
  const pid_t child = fork();
  if (child == 0) {
    const int held = open(canary.c_str(), O_RDONLY);
    confine_helper();
    char text[8];
    int wrong = read(held, text, sizeof text) == 8 ? 0 : 1;  // open files stay open
    const auto must_fail = [&](bool failed) { wrong += failed ? 0 : 1; };
    must_fail(open(canary.c_str(), O_RDONLY) < 0);
    must_fail(open((canary + "2").c_str(), O_RDWR | O_CREAT, 0600) < 0);
    must_fail(openat(AT_FDCWD, "/dev/null", O_RDONLY) < 0);
    must_fail(std::fopen("/etc/passwd", "r") == nullptr);
    must_fail(socket(AF_UNIX, SOCK_STREAM, 0) < 0);
    must_fail(socket(AF_INET, SOCK_STREAM, 0) < 0);
    must_fail(kill(getppid(), 0) < 0);
    must_fail(execl("/bin/true", "true", nullptr) < 0);
    _exit(wrong);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << "the exit status counts what was not refused";
}

TEST(NewFile, FourWritersLeaveOneWhole) {
  Folder folder;
  const auto path = folder / "u.bin";
  folder.write("u.bin.part", "the user's own");
  std::filesystem::create_symlink(folder / "planted", folder / "u.bin.part2");
  const int rounds = std::getenv("KIBORI_CAMPAIGN") ? 1000 : 20;
  for (int round = 0; round < rounds; round++) {
    std::vector<std::thread> writers;
    for (char c = 'a'; c < 'e'; c++)
      writers.emplace_back([&path, c] {
        NewFile file(path);
        for (int i = 0; i < 50; i++) file.write(std::string(1000, c));
        EXPECT_TRUE(file.commit().ok());
      });
    for (auto& writer : writers) writer.join();
    const std::vector<char> whole = read_file(path).value();
    ASSERT_EQ(whole.size(), 50000u);
    for (const char c : whole) ASSERT_EQ(c, whole[0]);
  }
  EXPECT_EQ(read_file(folder / "u.bin.part").value().size(), 14u);
  // No other file is left.
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder / "."))
    files++;
  EXPECT_EQ(files, 3u);
}
TEST(NewFile, KeepsWhoMayReadWhatWasThere) {
  Folder folder;
  const auto mode = [&](const char* name) {
    return std::filesystem::status(folder / name).permissions() & std::filesystem::perms::mask;
  };
  const auto put = [&](const char* name) {
    NewFile file(folder / name);
    file.write("x");
    ASSERT_TRUE(file.commit().ok());
  };
  const mode_t before = umask(0027);
  put("new");
  EXPECT_EQ(mode("new"), std::filesystem::perms(0640));
  std::filesystem::permissions(folder / "new", std::filesystem::perms(0604));
  put("new");
  EXPECT_EQ(mode("new"), std::filesystem::perms(0604));
  umask(before);
  std::filesystem::create_symlink("new", folder / "link");
  put("link");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
}
TEST(ReadFile, RefusesWhatMayNeverEnd) {
  Folder folder;
  ASSERT_EQ(mkfifo((folder / "pipe.toml").c_str(), 0600), 0);
  for (const auto& path : {folder / "pipe.toml", std::filesystem::path("/dev/zero"), folder / "."})
    EXPECT_NE(read_file(path).error().find("is not a regular file"), std::string::npos);
  EXPECT_NE(read_file(folder / "none").error().find("no such file"), std::string::npos);
  folder.write("long", std::string(100, 'x'));
  EXPECT_NE(read_file(folder / "long", 99).error().find("100 bytes; at most 99"),
            std::string::npos);
  EXPECT_TRUE(read_file(folder / "long", 100).ok());
}

}  // namespace
}  // namespace kibori::files_tests
