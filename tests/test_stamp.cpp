// SPDX-License-Identifier: MIT
// Stamps: letters against the rasteriser of the font's own library; pictures and meshes against
// their sources. Meshes that are not convex are compared with dense sampling.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <ft2build.h>
#include FT_FREETYPE_H

#include <gtest/gtest.h>

#include <kibori/scene/lettering.h>
#include <kibori/scene/stamp.h>
#include <kibori/edit/edit.h>
#include <kibori/formats/png_file.h>
#include <kibori/geometry/mesh_info.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/solid/tool.h>

#include "tests/support.h"

namespace kibori::stamp_tests {
namespace {

using test::Folder;
using test::Random;

constexpr const char* kSans = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

double volume_of(const TriangleMesh& mesh) {
  double six = 0;
  for (const auto& t : mesh.triangles)
    six += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  return six / 6;
}

const TriangleMesh& mesh_of(const Tool& tool) { return *std::get<MeshTool>(tool).mesh; }

// The area of a letter [mm^2] if a capital H is 1 mm high: the sum of the grey pixels of FreeType's
// rasteriser.
double area_of(FT_Face face, char letter) {
  constexpr int kPixels = 600;
  FT_Set_Pixel_Sizes(face, 0, kPixels);
  FT_Load_Char(face, 'H', FT_LOAD_NO_SCALE);
  const double capital = static_cast<double>(face->glyph->metrics.height) / face->units_per_EM;
  FT_Load_Char(face, static_cast<FT_ULong>(letter), FT_LOAD_NO_HINTING | FT_LOAD_RENDER);
  const FT_Bitmap& bitmap = face->glyph->bitmap;
  double sum = 0;
  for (unsigned y = 0; y < bitmap.rows; y++)
    for (unsigned x = 0; x < bitmap.width; x++)
      sum += bitmap.buffer[y * static_cast<unsigned>(bitmap.pitch) + x] / 255.0;
  return sum / (kPixels * kPixels) / (capital * capital);
}

TEST(Lettering, EveryLetterHasItsAreaAndIsClosed) {
  FT_Library library;
  FT_Face face;
  ASSERT_EQ(FT_Init_FreeType(&library), 0);
  ASSERT_EQ(FT_New_Face(library, kSans, 0, &face), 0);
  for (const char letter :
       std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789&?!@%$")) {
    const auto mesh = letter_mesh({std::string(1, letter), kSans, 20, 3, 0});
    ASSERT_TRUE(mesh) << letter << ": " << mesh.error();
    const MeshInfo info = mesh_info(surface_of_mesh(mesh.value()));
    EXPECT_TRUE(info.closed) << letter;
    const double wanted = area_of(face, letter) * 20 * 20 * 3;
    EXPECT_NEAR(volume_of(mesh.value()), wanted, 0.004 * wanted) << letter;
    const Box box = mesh.value().bounds();
    EXPECT_NEAR(box.centre().x(), 0, 1e-9);
    EXPECT_NEAR(box.centre().y(), 0, 1e-9);
    EXPECT_EQ(box.min.z(), 0);
    EXPECT_EQ(box.max.z(), 3);
  }
  FT_Done_Face(face);
  FT_Done_FreeType(library);
}

TEST(Lettering, CapitalsHaveTheRequestedHeight) {
  const auto mesh = letter_mesh({"H", "DejaVu Serif", 12.5, 2, 0});
  ASSERT_TRUE(mesh) << mesh.error();
  EXPECT_NEAR(mesh.value().bounds().size().y(), 12.5, 1e-9);
}

// Accents overlap their letters, and letters overlap each other; lines are below each other.
TEST(Lettering, WhatOverlapsIsOneSolid) {
  for (const char* text : {"Ägypten", "Œuvre\nﬁn", "ÀÇÊ\n\nñ", "ffi"}) {
    const auto mesh = letter_mesh({text, "DejaVu Serif:bold", 8, 2, 0});
    ASSERT_TRUE(mesh) << mesh.error();
    EXPECT_TRUE(mesh_info(surface_of_mesh(mesh.value())).closed) << text;
    EXPECT_GT(volume_of(mesh.value()), 0);
  }
  const auto one = letter_mesh({"H", kSans, 10, 1, 0}),
             two = letter_mesh({"H\nH", kSans, 10, 1, 0});
  ASSERT_TRUE(one && two);
  EXPECT_NEAR(volume_of(two.value()), 2 * volume_of(one.value()), 1e-6);
  EXPECT_GT(two.value().bounds().size().y(), 20);
}

TEST(Lettering, EveryInstalledFontMakesClosedSolids) {
  int tried = 0;
  for (const std::string& family : font_families()) {
    if (++tried > test::rounds_of("KIBORI_FONTS", 60)) break;
    const auto mesh = letter_mesh({"HQgR&8", family, 10, 2, 0});
    if (!mesh) {  // a font of another script, or one whose letters are pictures
      EXPECT_EQ(mesh.error().find('\n'), std::string::npos);
      continue;
    }
    EXPECT_TRUE(mesh_info(surface_of_mesh(mesh.value())).closed) << family;
    EXPECT_GT(volume_of(mesh.value()), 0) << family;
  }
  EXPECT_GT(tried, 0);
}

TEST(Lettering, ReportsInvalidInput) {
  const auto error_of = [](const Lettering& lettering) {
    const auto mesh = letter_mesh(lettering);
    return mesh ? std::string("(none)") : mesh.error();
  };
  EXPECT_NE(error_of({"A", "No Such Font", 10, 2, 0}).find("no font called 'No Such Font'"),
            std::string::npos);
  EXPECT_NE(error_of({"A", "/nowhere/a.ttf", 10, 2, 0}).find("no such font file"),
            std::string::npos);
  EXPECT_NE(error_of({"A", KIBORI_SOURCE_DIR "/CMakeLists.txt", 10, 2, 0}).find("can't be read"),
            std::string::npos);
  EXPECT_NE(error_of({"日", kSans, 10, 2, 0}).find("has no letter '日'"), std::string::npos);
  EXPECT_NE(error_of({"", kSans, 10, 2, 0}).find("no letters"), std::string::npos);
  EXPECT_NE(error_of({" \n ", kSans, 10, 2, 0}).find("no letters"), std::string::npos);
  EXPECT_NE(error_of({"\xff\xfe", kSans, 10, 2, 0}).find("not UTF-8"), std::string::npos);
  EXPECT_NE(error_of({std::string(201, 'A'), kSans, 10, 2, 0}).find("200 letters"),
            std::string::npos);
  EXPECT_NE(error_of({"A", kSans, 0, 2, 0}).find("0.1 to 1000"), std::string::npos);
  EXPECT_NE(error_of({"A", kSans, std::nan(""), 2, 0}).find("0.1 to 1000"), std::string::npos);
}

// A block into which the tool is pressed from above.
std::unique_ptr<TriDexel> pressed(const Tool& tool, double depth_mm, double pitch_mm,
                                  double side_mm = 24) {
  Lattice lattice = make_lattice(Vec3(side_mm, side_mm, 8), pitch_mm, 1).value();
  auto model = std::make_unique<TriDexel>(lattice);
  model->fill_block({Vec3::Zero(), Vec3(side_mm, side_mm, 8)}, 0);
  const Vec3 top(side_mm / 2, side_mm / 2, 8);
  DirectTool stroke(*model, Pose{top + Vec3(0, 0, 1), Mat3::Identity()});
  for (const double z : {0.0, -depth_mm, 1.0})
    EXPECT_TRUE(stroke.advance(tool, top + Vec3(0, 0, z), Vec3::Zero(), Mode::cut,
                               {ForceModel::energy, 6}, {Material{}}));
  return model;
}

bool is_material(const TriDexel& model, const Vec3& p) {
  const LatticePoint at = model.lattice().to_lattice(p);
  bool found = false;
  model.field(Axis::z).view().for_spans(
      static_cast<int>(std::floor(at[0])), static_cast<int>(std::floor(at[1])),
      [&](const Span& s) { found |= s.in <= at[2] && at[2] < s.out; });
  return found;
}

TEST(Stamp, TextReadsFromAboveAndTakesItsVolume) {
  const auto tool = text_stamp({"L", kSans, 14, 6, 0}, 0.1);
  ASSERT_TRUE(tool) << tool.error();
  const auto model = pressed(tool.value(), 2, 0.1);
  const double whole = 24 * 24 * 8, wanted = volume_of(mesh_of(tool.value())) / 6 * 2;
  EXPECT_NEAR(whole - model->volume_mm3(), wanted, 0.01 * wanted);
  // An L: a bar on the left, one at the bottom, wood elsewhere.
  const Box box = mesh_of(tool.value()).bounds();
  const Vec3 middle(12, 12, 7);
  const auto wood = [&](double right, double up) {
    return is_material(*model, middle + Vec3(right * box.max.x(), up * box.max.y(), 0));
  };
  EXPECT_FALSE(wood(-0.9, 0.9));
  EXPECT_FALSE(wood(-0.9, -0.95));
  EXPECT_FALSE(wood(0.9, -0.95));
  EXPECT_TRUE(wood(0.5, 0.5));
  EXPECT_TRUE(is_material(*model, Vec3(12 - 0.9 * box.max.x(), 12, 5.9)));
}

TEST(Stamp, APictureIsAsDeepAsItIsWhite) {
  Folder folder;
  // White on the right, black on the left, and grey at the top.
  std::vector<uint8_t> pixels(40 * 20);
  for (int y = 0; y < 20; y++)
    for (int x = 0; x < 40; x++)
      pixels[static_cast<size_t>(y * 40 + x)] = y < 8 ? 128 : x < 20 ? 0 : 255;
  ASSERT_TRUE(write_png_grey8(folder / "a.png", 40, 20, pixels));
  const auto tool = picture_stamp(folder / "a.png", {16, 2, 4, false}, 0.1);
  ASSERT_TRUE(tool) << tool.error();
  const Box box = mesh_of(tool.value()).bounds();
  EXPECT_NEAR(box.size().x(), 16, 1e-5);
  EXPECT_NEAR(box.min.z(), 0, 1e-9);
  EXPECT_NEAR(box.max.z(), 6, 1e-5);
  EXPECT_TRUE(mesh_info(surface_of_mesh(mesh_of(tool.value()))).closed);
  EXPECT_GT(volume_of(mesh_of(tool.value())), 0);
  const auto model = pressed(tool.value(), 2, 0.1);
  const auto depth = [&](double x, double y) {
    double z = 8;
    while (z > 0 && !is_material(*model, Vec3(x, y, z))) z -= 0.01;
    return 8 - z;
  };
  EXPECT_NEAR(depth(17, 10), 2, 0.03);  // white
  EXPECT_NEAR(depth(7, 10), 0, 0.03);   // black
  EXPECT_NEAR(depth(7, 15), 2 * 128 / 255.0, 0.03);
  const auto inverse = picture_stamp(folder / "a.png", {16, 2, 4, true}, 0.1);
  ASSERT_TRUE(inverse);
  const auto other = pressed(inverse.value(), 2, 0.1);
  EXPECT_TRUE(is_material(*other, Vec3(17, 10, 7.9)));
  EXPECT_FALSE(is_material(*other, Vec3(7, 10, 6.1)));
}

TEST(Stamp, AMeshRestsOnItsLowestPoint) {
  Folder folder;
  // A pyramid on its point, off the origin.
  std::ofstream(folder / "p.obj") << "v 5 5 3\nv 3 3 9\nv 7 3 9\nv 7 7 9\nv 3 7 9\n"
                                     "f 1 3 2\nf 1 4 3\nf 1 5 4\nf 1 2 5\nf 2 3 4 5\n";
  const auto tool = mesh_stamp(folder / "p.obj", 8);
  ASSERT_TRUE(tool) << tool.error();
  const Box box = mesh_of(tool.value()).bounds();
  EXPECT_TRUE(box.min.isApprox(Vec3(-4, -4, 0), 1e-6));
  EXPECT_TRUE(box.max.isApprox(Vec3(4, 4, 12), 1e-6));
  EXPECT_NEAR(volume_of(mesh_of(tool.value())), 8 * 8 * 12 / 3.0, 1e-3);
  std::ofstream(folder / "open.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const auto open = mesh_stamp(folder / "open.obj", 8);
  ASSERT_FALSE(open);
  EXPECT_NE(open.error().find("holes"), std::string::npos) << open.error();
}

// ---- Sweeps of letters against dense sampling

// True if a point is in the extruded letters: by the crossings of a line through the mesh in a
// general direction.
bool in_mesh(const TriangleMesh& mesh, const Vec3& p) {
  const Vec3 direction(0.5477, 0.3137, 0.7759);
  int winding = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vec3 n = (b - a).cross(c - a);
    const double facing = n.dot(direction);
    if (facing == 0) continue;
    const double s = n.dot(a - p) / facing;
    if (s <= 0) continue;
    const Vec3 q = p + s * direction;
    if (n.dot((b - a).cross(q - a)) >= 0 && n.dot((c - b).cross(q - b)) >= 0 &&
        n.dot((a - c).cross(q - c)) >= 0)
      winding += facing > 0 ? 1 : -1;
  }
  return winding > 0;
}

TEST(Stamp, SweptLettersAgreeWithDenseSampling) {
  Random random;
  const auto tool = text_stamp({"R&", kSans, 10, 3, 0}, 0.5);
  ASSERT_TRUE(tool) << tool.error();
  const TriangleMesh& mesh = mesh_of(tool.value());
  constexpr double kNear = 0.06;  // [mm], of cells of 0.5: gaps between the sampled poses
  int checked = 0;
  for (int round = 0; round < test::rounds_of("KIBORI_ROUNDS", 15); round++) {
    Lattice lattice;
    lattice.nodes = Index3(64, 64, 64);
    lattice.pitch_mm = 0.5;
    const Pose start{Vec3(16, 16, 16) + random.in_box(-3, 3),
                     frame_from_axis(random.direction(), random.uniform(0, 6))};
    const Vec3 motion = random.integer(0, 4) == 0 ? Vec3(random.uniform(0.1, 4) * start.axis())
                                                  : Vec3(random.uniform(0, 4) * random.direction());
    const SweptTool swept(tool.value(), start, motion, lattice);
    const int poses = std::max(2, static_cast<int>(std::ceil(motion.norm() / (kNear / 2))));
    for (int sample = 0; sample < 60; sample++) {
      const Axis axis = kAxes[static_cast<size_t>(random.integer(0, 2))];
      const RayTile tile{axis, 16 * random.integer(1, 2), 16 * random.integer(1, 2)};
      const int slot = random.integer(0, kTileRays - 1);
      Vec3 at;
      at[u_index(axis)] = tile.u0 + slot % kTileSide + 0.5;
      at[v_index(axis)] = tile.v0 + slot / kTileSide + 0.5;
      const double depth = random.uniform(10, 54);
      at[depth_index(axis)] = depth;
      const Vec3 world = lattice.to_mm(LatticePoint{at});
      // Also tests points around. If their results differ, this point is too near the surface.
      bool any = false, all = true;
      for (const Vec3& off :
           {Vec3(Vec3::Zero()), Vec3(kNear, 0, 0), Vec3(-kNear, 0, 0), Vec3(0, kNear, 0),
            Vec3(0, -kNear, 0), Vec3(0, 0, kNear), Vec3(0, 0, -kNear)}) {
        bool in = false;
        for (int i = 0; i <= poses && !in; i++) {
          const Vec3 tip = start.tip + motion * i / poses;
          in = in_mesh(mesh, start.frame.transpose() * (world + off - tip));
        }
        any |= in;
        all &= in;
      }
      if (any != all) continue;
      checked++;
      bool found = false;
      SpanLayer layer;
      for (int l = 0;; l++) {
        layer.last = false;
        layer.normals_ready = 0;
        if (!swept.solid().spans(tile, l, layer)) break;
        found |= layer.lo[slot] <= depth && depth < layer.hi[slot];
      }
      EXPECT_EQ(found, all) << random.note() << " round " << round << " sample " << sample;
    }
  }
  EXPECT_GT(checked, 100);
}

}  // namespace
}  // namespace kibori::stamp_tests
