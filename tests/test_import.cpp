// SPDX-License-Identifier: MIT
// The guesses about a file before its import, and the orientation of the piece after it.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <kibori/run/carving.h>
#include <kibori/run/documents.h>
#include <kibori/run/replay.h>
#include <kibori/report/import_report.h>
#include <kibori/geometry/cluster.h>
#include <kibori/geometry/mesh_info.h>
#include <kibori/haptics/materials.h>
#include "apps/studio/session/stock_scene.h"
#include <kibori/surface/surface.h>

#include "tests/support.h"

namespace kibori::import_tests {
namespace {

using test::Folder;

void add_box(TriangleMesh& mesh, const Vec3& low, const Vec3& high) {
  const auto first = static_cast<uint32_t>(mesh.vertices.size());
  for (int i = 0; i < 8; i++)
    mesh.vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                               i & 4 ? high.z() : low.z());
  constexpr uint32_t kSides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& s : kSides) {
    mesh.triangles.push_back({first + s[0], first + s[1], first + s[2]});
    mesh.triangles.push_back({first + s[0], first + s[2], first + s[3]});
  }
}

// A block with three different sides, and a smaller one as a marker at one of its corners.
constexpr double kMarkX = 8, kMarkY = 3, kMarkZ = 4;
TriangleMesh marked_block() {
  TriangleMesh mesh;
  add_box(mesh, {0, 0, 0}, {6, 10, 16});
  add_box(mesh, {5, 0, 0}, {kMarkX, kMarkY, kMarkZ});
  return mesh;
}

void write_stl(const std::filesystem::path& path, const TriangleMesh& mesh, double scale = 1) {
  std::ofstream file(path);
  file << "solid t\n";
  for (const auto& t : mesh.triangles) {
    file << "facet normal 0 0 0\nouter loop\n";
    for (const uint32_t v : t) file << "vertex " << (scale * mesh.vertices[v]).transpose() << "\n";
    file << "endloop\nendfacet\n";
  }
  file << "endsolid t\n";
}

// An upright figure along an axis: a broad block as base, and a narrow one on it, off the middle.
TriangleMesh figure(int up) {
  TriangleMesh mesh;
  const auto place = [up](double u, double v, double w) {
    Vec3 p;
    p[up] = w;
    p[(up + 1) % 3] = u;
    p[(up + 2) % 3] = v;
    return p;
  };
  add_box(mesh, place(0, 0, 0), place(50, 40, 10));
  add_box(mesh, place(20, 15, 5), place(30, 25, 90));
  // A peg on each side, so that it has no other flat side.
  add_box(mesh, place(-4, 18, 4), place(54, 20, 6));
  add_box(mesh, place(24, -4, 4), place(26, 44, 6));
  return mesh;
}

std::vector<Orientation> all_turns() {
  std::vector<Orientation> turns;
  for (int up = 0; up < 6; up++)
    for (int front = 0; front < 6; front++)
      if (const Orientation o{static_cast<SignedAxis>(up), static_cast<SignedAxis>(front)};
          is_turn(o))
        turns.push_back(o);
  return turns;
}

Box bounds_of(const Surface& surface) {
  Box box;
  for (const SurfaceVertex& v : surface.vertices)
    box.include(Vec3(v.position[0], v.position[1], v.position[2]));
  return box;
}

bool has_corner(const Surface& surface, const Vec3& at, double within) {
  for (const SurfaceVertex& v : surface.vertices)
    if ((Vec3(v.position[0], v.position[1], v.position[2]) - at).norm() < within) return true;
  return false;
}

// The block is at the origin, with its size unchanged, and the marker is where the turn moves it.
void expect_turned(const TriDexel& model, const Orientation& orientation, double scale,
                   double pitch) {
  const Surface surface = extract_surface(model.snapshot(), 1);
  const Mat3 turn = rotation(orientation);
  const Vec3 low = (turn * Vec3::Zero()).cwiseMin(turn * Vec3(kMarkX, 10, 16)),
             size = scale * (turn * Vec3(kMarkX, 10, 16)).cwiseAbs();
  const Box box = bounds_of(surface);
  EXPECT_LT(box.min.cwiseAbs().maxCoeff(), 0.01 * pitch);
  EXPECT_LT((box.max - size).cwiseAbs().maxCoeff(), 0.01 * pitch);
  const double volume = std::pow(scale, 3) * (6 * 10 * 16 + 2 * kMarkY * kMarkZ);
  EXPECT_NEAR(model.volume_mm3(), volume, 1e-3 * volume);
  const auto lands = [&](const Vec3& corner) { return Vec3(scale * (turn * corner - low)); };
  for (const Vec3& corner : {Vec3(kMarkX, 0, 0), Vec3(kMarkX, kMarkY, 0), Vec3(kMarkX, 0, kMarkZ),
                             Vec3(kMarkX, kMarkY, kMarkZ), Vec3(0, 10, 16), Vec3(6, 10, 16)})
    EXPECT_TRUE(has_corner(surface, lands(corner), 0.02 * pitch)) << corner.transpose();
  for (const Vec3& nothing : {Vec3(kMarkX, 10, 0), Vec3(kMarkX, 0, 16), Vec3(kMarkX, 10, 16)})
    EXPECT_FALSE(has_corner(surface, lands(nothing), pitch)) << nothing.transpose();
}

TEST(Orientation, ThereAreTwentyFourRotations) {
  std::set<std::vector<double>> seen;
  for (const Orientation& o : all_turns()) {
    const Mat3 turn = rotation(o);
    EXPECT_EQ(turn.determinant(), 1);
    EXPECT_EQ(turn * turn.transpose(), Mat3::Identity());
    EXPECT_EQ(Vec3(turn * direction(o.up)), Vec3(0, 0, 1));
    EXPECT_EQ(Vec3(turn * direction(o.front)), Vec3(0, -1, 0));
    seen.insert(std::vector<double>(turn.data(), turn.data() + 9));
  }
  EXPECT_EQ(seen.size(), 24u);
  EXPECT_EQ(rotation(Orientation{}), Mat3::Identity());
  // The reader of GLB files turns meshes in this way.
  EXPECT_EQ(Vec3(rotation(standing(SignedAxis::plus_y)) * Vec3(1, 2, 3)), Vec3(1, -3, 2));
}

TEST(Orientation, NamesAreReadAsTheyAreWritten) {
  for (int i = 0; i < 6; i++) {
    const auto axis = static_cast<SignedAxis>(i);
    EXPECT_EQ(parse_signed_axis(signed_axis_text(axis)), axis);
    EXPECT_TRUE(is_turn(standing(axis)));
  }
  for (const char* wrong : {"", "w", "X", "--x", "xy", "- x", "up"})
    EXPECT_FALSE(parse_signed_axis(wrong)) << wrong;
}

TEST(Orientation, AStockKeepsItsRotation) {
  Folder folder;
  write_stl(folder / "block.stl", marked_block());
  for (const Orientation& o : all_turns()) {
    SCOPED_TRACE(std::string(signed_axis_text(o.up)) + ", " + signed_axis_text(o.front));
    const Result<Scene> scene = file_scene(folder / "block.stl", {32, 80, 0, o});
    ASSERT_TRUE(scene.ok()) << scene.error();
    const auto model = make_stock(scene.value().stock, "a test", {});
    ASSERT_TRUE(model.ok()) << model.error();
    expect_turned(*model.value(), o, 2, 0.4);
  }
}

TEST(Orientation, ADocumentKeepsItForAnotherPitch) {
  Folder folder;
  write_stl(folder / "block.stl", marked_block());
  const Orientation o{SignedAxis::minus_x, SignedAxis::plus_z};
  const Result<Scene> scene = file_scene(folder / "block.stl", {32, 40, 0, o});
  ASSERT_TRUE(scene.ok());
  {
    const auto model = make_stock(scene.value().stock, "a test", {});
    ASSERT_TRUE(model.ok()) << model.error();
    const auto made = new_document(folder / "t.kibori", scene.value(), *model.value());
    ASSERT_TRUE(made.ok()) << made.error();
  }
  const auto document = Document::open(folder / "t.kibori", Document::Access::read);
  ASSERT_TRUE(document.ok()) << document.error();
  const auto text = document.value()->stock();
  ASSERT_TRUE(text.ok());
  const auto json = nlohmann::json::parse(text.value());
  EXPECT_EQ(json["up"], "-x");
  EXPECT_EQ(json["front"], "z");
  ReplayOptions options;
  options.pitch_mm = 0.5;
  const Result<Replay> again = replay_document(*document.value(), options);
  ASSERT_TRUE(again.ok()) << again.error();
  expect_turned(*again.value().carving.model, o, 2, 0.5);
}

TEST(Orientation, AScenesKeysTurnItsStock) {
  Folder folder;
  write_stl(folder / "block.stl", marked_block());
  const auto model_of = [&](const std::string& keys) {
    const auto scene =
        parse_scene("[stock]\nmesh = \"block.stl\"\npitch = 0.25\n" + keys +
                        "[tool]\nshape = \"ball\"\nradius = 1\n[[move]]\nto = [0, 0, 99]\n",
                    "t.toml", folder.path);
    EXPECT_TRUE(scene.ok()) << scene.error();
    auto model = make_stock(scene.value().stock, "t.toml", {});
    EXPECT_TRUE(model.ok()) << model.error();
    return std::move(model).value();
  };
  expect_turned(*model_of(""), {}, 1, 0.25);
  expect_turned(*model_of("up = \"y\"\n"), {SignedAxis::plus_y, SignedAxis::plus_z}, 1, 0.25);
  expect_turned(*model_of("up = \"-x\"\n"), {SignedAxis::minus_x, SignedAxis::minus_y}, 1, 0.25);
  expect_turned(*model_of("up = \"-z\"\nfront = \"x\"\n"),
                {SignedAxis::minus_z, SignedAxis::plus_x}, 1, 0.25);
  expect_turned(*model_of("front = \"-x\"\n"), {SignedAxis::plus_z, SignedAxis::minus_x}, 1, 0.25);
}

TEST(Import, SizesThatCanNotBeMeantAreReplaced) {
  struct Case {
    const char* ending;
    double longest_mm;
    const char* unit;
    double becomes_mm;
  };
  for (const Case& c :
       {Case{".stl", 60, "mm", 60}, Case{".stl", 0.156, "fit", 80}, Case{".obj", 2, "fit", 80},
        Case{".ply", 5000, "fit", 80}, Case{".glb", 156, "m", 156}, Case{".glb", 1800, "fit", 80},
        Case{".gltf", 156, "m", 156}, Case{".3mf", 25.4, "mm", 25.4},
        Case{".off", 999, "mm", 999}}) {
    const SizeGuess guess = guess_size(c.ending, c.longest_mm);
    EXPECT_EQ(guess.unit, c.unit) << c.ending << " " << c.longest_mm;
    EXPECT_EQ(guess.longest_mm, c.becomes_mm) << c.ending << " " << c.longest_mm;
    EXPECT_FALSE(guess.why.empty());
  }
}

TEST(Import, UpIsTheFormatsByDefault) {
  const auto up = [](const char* ending, const TriangleMesh& mesh) {
    return std::string(signed_axis_text(guess_up(ending, mesh).orientation.up));
  };
  for (const char* ending : {".stl", ".obj", ".ply", ".off", ".3mf"}) {
    EXPECT_EQ(up(ending, figure(1)), "y") << ending;
    EXPECT_EQ(up(ending, figure(2)), "z") << ending;
  }
  for (const char* ending : {".glb", ".gltf"})  // was turned when it was read
    EXPECT_EQ(guess_up(ending, figure(1)).orientation, Orientation{}) << ending;
  TriangleMesh plate;  // stable on both sides
  add_box(plate, {0, 0, 0}, {80, 50, 10});
  EXPECT_EQ(up(".obj", plate), "y");
  EXPECT_EQ(up(".stl", plate), "z");
  EXPECT_EQ(up(".ply", plate), "z");
}

TEST(Import, ALargeMeshIsShownByFewerTriangles) {
  TriangleMesh ball;
  constexpr int kRings = 300, kSlices = 600;
  const double pi = std::acos(-1.0);
  for (int i = 0; i <= kRings; i++)
    for (int j = 0; j < kSlices; j++) {
      const double a = pi * i / kRings, b = 2 * pi * j / kSlices;
      ball.vertices.emplace_back(30 * std::sin(a) * std::cos(b), 20 * std::sin(a) * std::sin(b),
                                 10 * std::cos(a));
    }
  for (uint32_t i = 0; i < kRings; i++)
    for (uint32_t j = 0; j < kSlices; j++) {
      const uint32_t a = i * kSlices + j, b = i * kSlices + (j + 1) % kSlices;
      ball.triangles.push_back({a, a + kSlices, b});
      ball.triangles.push_back({b, a + kSlices, b + kSlices});
    }
  const TriangleMesh few = cluster(ball, 30000);
  EXPECT_LE(few.triangles.size(), 30000u);
  EXPECT_GT(few.triangles.size(), 10000u);
  for (const auto& t : few.triangles)
    for (const uint32_t v : t) ASSERT_LT(v, few.vertices.size());
  const MeshInfo info = mesh_info(surface_of_mesh(few));
  EXPECT_NEAR(info.volume_mm3, 4 * pi / 3 * 6000, 0.03 * 4 * pi / 3 * 6000);
  EXPECT_LT((info.bounds.size() - Vec3(60, 40, 20)).cwiseAbs().maxCoeff(), 1.5);
  // A mesh that is small enough is unchanged.
  TriangleMesh block;
  add_box(block, {1, 2, 3}, {4, 6, 8});
  EXPECT_EQ(cluster(block, 30000).triangles.size(), 12u);
  EXPECT_EQ(cluster(block, 30000).bounds().size(), Vec3(3, 4, 5));
  EXPECT_TRUE(cluster(TriangleMesh{{Vec3::Zero()}, {{0, 0, 0}, {0, 0, 0}}}, 1).triangles.empty());
}

TEST(Import, AReportNamesTheKind) {
  Folder folder;
  TriangleMesh mesh = marked_block();
  mesh.triangles.pop_back();
  write_stl(folder / "open.stl", mesh, 0.001);
  const Result<ImportReport> report = report_import(folder / "open.stl");
  ASSERT_TRUE(report.ok()) << report.error();
  const auto json = nlohmann::json::parse(import_report_json(report.value()));
  EXPECT_EQ(json["kind"], "mesh");
  EXPECT_EQ(json["triangles"], 23);
  EXPECT_EQ(json["unit"], "fit");
  EXPECT_EQ(json["longest_mm"], 80);
  ASSERT_EQ(json["repairs"].size(), 2u);
  EXPECT_EQ(json["repairs"][0].get<std::string>().rfind("It is open at 3 edges", 0), 0u)
      << json["repairs"][0];
  const std::vector<uint8_t> preview = import_preview(report.value());
  uint32_t counts[2];
  std::memcpy(counts, preview.data(), sizeof counts);
  EXPECT_EQ(counts[0], 16u);
  EXPECT_EQ(counts[1], 23u);
  EXPECT_EQ(preview.size(), 8 + 12 * 16 + 12 * 23u);
  TriangleMesh block, inward;
  add_box(block, {0, 0, 0}, {30, 20, 10});
  add_box(inward, {30, 20, 10}, {0, 0, 0});
  write_stl(folder / "block.stl", block);
  write_stl(folder / "inward.stl", inward);
  EXPECT_TRUE(report_import(folder / "block.stl").value().repairs.empty());
  EXPECT_EQ(report_import(folder / "inward.stl").value().repairs,
            std::vector<std::string>{"Its faces point inward: they are reversed."});
  std::ofstream(folder / "none.stl") << "solid x\nendsolid x\n";
  EXPECT_FALSE(report_import(folder / "none.stl").ok());
  EXPECT_FALSE(report_import(folder / "nowhere.obj").ok());
}

// A labelled volume: its labels, its preview, and the stock made from it.
TEST(Import, ALabelledVolume) {
  Folder folder;
  // 24 x 16 x 10 voxels of 1 mm, a shell of air; the lower half is label 7, the upper label 2.
  std::string voxels;
  for (int z = 0; z < 10; z++)
    for (int y = 0; y < 16; y++)
      for (int x = 0; x < 24; x++) {
        const bool air = x < 2 || x > 21 || y < 2 || y > 13 || z < 2 || z > 7;
        voxels += air ? '\0' : z < 5 ? '\7' : '\2';
      }
  std::ofstream(folder / "scan.nrrd", std::ios::binary)
      << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 24 16 10\nspacings: 1 1 1\n"
      << "encoding: raw\nSegment0_LabelValue:=2\nSegment0_Name:=Oak\n\n"
      << voxels;
  const Result<ImportReport> report = report_import(folder / "scan.nrrd");
  ASSERT_TRUE(report.ok()) << report.error();
  ASSERT_EQ(report.value().kind, ImportReport::Kind::volume);
  ASSERT_EQ(report.value().labels.size(), 2u);
  const LabelReport &upper = report.value().labels[0], &lower = report.value().labels[1];
  EXPECT_EQ(upper.label, 2);
  EXPECT_EQ(upper.name, "Oak");
  EXPECT_EQ(known_materials()[upper.material].name, "oak");
  EXPECT_EQ(upper.volume_mm3, 20 * 12 * 3);
  EXPECT_EQ(lower.name, "label 7");
  // Its edges are rounded.
  EXPECT_NEAR(report.value().area_mm2, 2 * (20 * 12 + 12 * 6 + 6 * 20), 100);
  // The preview is where the voxels are, and each half has its label.
  const TriangleMesh& preview = report.value().preview;
  ASSERT_EQ(report.value().kinds.size(), preview.vertices.size());
  for (size_t i = 0; i < preview.vertices.size(); i++) {
    const Vec3 p = 24 * preview.vertices[i];
    EXPECT_TRUE(p.x() > 1.5 && p.x() < 22.5 && p.z() > 1.5 && p.z() < 8.5) << p.transpose();
    if (std::abs(p.z() - 5) > 0.6) {
      EXPECT_EQ(report.value().kinds[i], p.z() > 5 ? 0u : 1u) << p.transpose();
    }
  }
  const nlohmann::json json = nlohmann::json::parse(import_report_json(report.value()));
  EXPECT_EQ(json["kind"], "volume");
  EXPECT_EQ(json["labels"][1]["label"], 7);
  EXPECT_EQ(import_preview(report.value()).size(),
            8 + 16 * preview.vertices.size() + 12 * preview.triangles.size());

  FileStock how{24, 96};
  how.labels = {{2, 3}, {7, 0}};
  const Result<Scene> scene = file_scene(folder / "scan.nrrd", how);
  ASSERT_TRUE(scene.ok()) << scene.error();
  const auto model = make_stock(scene.value().stock, "a test", {});
  ASSERT_TRUE(model.ok()) << model.error();
  EXPECT_NEAR(model.value()->volume_mm3(), 20 * 12 * 6, 15);
  how.labels = {{2, 3}};
  const Result<Scene> part = file_scene(folder / "scan.nrrd", how);
  ASSERT_TRUE(part.ok());
  EXPECT_FALSE(make_stock(part.value().stock, "a test", {}).ok());  // no material for label 7
  how.labels = {{2, 200}};
  EXPECT_FALSE(file_scene(folder / "scan.nrrd", how).ok());
  std::ofstream(folder / "air.nrrd", std::ios::binary)
      << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n"
      << std::string(8, '\0');
  EXPECT_FALSE(report_import(folder / "air.nrrd").ok());
}

TEST(Import, APictureMayBeInverted) {
  Folder folder;
  std::vector<uint16_t> pixels(40 * 20, 0);
  for (size_t i = 0; i < pixels.size(); i++)
    if (i % 40 < 10) pixels[i] = 65535;  // a quarter is white
  ASSERT_TRUE(write_png_grey16(folder / "map.png", 40, 20, pixels));
  const Result<ImportReport> report = report_import(folder / "map.png");
  ASSERT_TRUE(report.ok()) << report.error();
  EXPECT_EQ(nlohmann::json::parse(import_report_json(report.value()))["width"], 40);
  EXPECT_EQ(import_preview(report.value()).size(), 8 + 4 * 800u);
  for (const bool invert : {false, true}) {
    const Result<Scene> scene = file_scene(folder / "map.png", {80, 160, 0, {}, 8, 4, invert});
    ASSERT_TRUE(scene.ok()) << scene.error();
    const auto model = make_stock(scene.value().stock, "a test", {});
    ASSERT_TRUE(model.ok()) << model.error();
    // The step from white to black is a slope between two of the 40 points.
    const double high = (9.5 / 39) * 80, wide = invert ? 80 - high : high;
    const Box box = bounds_of(extract_surface(model.value()->snapshot(), 1));
    EXPECT_NEAR(box.size().z(), 12, 0.05);
    EXPECT_NEAR(model.value()->volume_mm3(), box.size().y() * (80 * 4 + wide * 8), 30);
    // Inverted, the left side is low.
    bool low_is_high = false;
    for (const SurfaceVertex& v : extract_surface(model.value()->snapshot(), 1).vertices)
      low_is_high = low_is_high || (v.position[0] < 5 && v.position[2] > 11);
    EXPECT_EQ(low_is_high, !invert);
  }
}

}  // namespace
}  // namespace kibori::import_tests
