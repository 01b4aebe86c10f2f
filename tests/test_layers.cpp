// SPDX-License-Identifier: MIT
// Outputs of models and meshes besides the surface: layers, height maps, simplification, measures,
// pictures.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include <kibori/scene/relief.h>
#include <kibori/scene/stock.h>
#include <kibori/edit/edit.h>
#include <kibori/formats/png_file.h>
#include <kibori/geometry/mesh_info.h>
#include <kibori/geometry/triangle_distance.h>
#include <kibori/measure/distance.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/picture/picture.h>
#include <kibori/surface/layers.h>
#include <kibori/surface/simplify.h>
#include <kibori/surface/surface.h>

#include "tests/support.h"
#include "tests/surface_check.h"

namespace kibori::layers_tests {
namespace {

using test::broken;
using test::Random;

double signed_area(const std::vector<std::array<double, 2>>& outline) {
  double sum = 0;
  for (size_t i = 0; i < outline.size(); i++) {
    const auto &a = outline[i], &b = outline[(i + 1) % outline.size()];
    sum += a[0] * b[1] - a[1] * b[0];
  }
  return sum / 2;
}

// A tube: outlines of a ring, against its formula and against its mask.
TEST(Layers, OfATube) {
  Lattice lattice;
  lattice.nodes = Index3(70, 60, 30);
  lattice.pitch_mm = 0.5;
  lattice.origin_mm = Vec3(-7, 3, 11);
  TriDexel model(lattice);
  Removed removed;
  const Vec3 foot = lattice.to_mm(LatticePoint{Vec3(33.2, 30.1, 4)});
  deposit(model, SweptTool(Flat{12, 10}, Pose{foot, Mat3::Identity()}, Vec3::Zero(), lattice), 0,
          {}, removed);
  cut(model,
      SweptTool(Flat{5, 20}, Pose{foot - Vec3(1, 0, 5), Mat3::Identity()}, Vec3::Zero(), lattice),
      {}, removed);
  const Snapshot snapshot = model.snapshot();
  const Layer layer = slice_layer(snapshot, 12);
  EXPECT_DOUBLE_EQ(layer.z_mm, 11 + 12.5 * 0.5);
  ASSERT_EQ(layer.outlines.size(), 2u);
  double outer = 0, inner = 0;
  for (const auto& outline : layer.outlines) {
    const double area = signed_area(outline);
    (area > 0 ? outer : inner) = area;
    const double radius = area > 0 ? 12 : 5;
    const Vec3 centre = area > 0 ? foot : Vec3(foot - Vec3(1, 0, 0));
    for (const auto& p : outline)
      EXPECT_NEAR(std::hypot(p[0] - centre.x(), p[1] - centre.y()), radius, 2e-5);
  }
  // Neighbouring points on the circles are joined by chords, so the areas differ slightly.
  EXPECT_NEAR(outer, M_PI * 144, 144 * 0.01);
  EXPECT_NEAR(inner, -M_PI * 25, 25 * 0.02);
  const std::vector<uint8_t> mask = mask_layer(snapshot, 12);
  const auto inside = static_cast<double>(std::count(mask.begin(), mask.end(), 255));
  EXPECT_NEAR(inside * 0.25, M_PI * (144 - 25), 6);
  EXPECT_TRUE(slice_layer(snapshot, 2).outlines.empty());
  const std::vector<int> layers = layers_of(snapshot, 1.0);
  ASSERT_EQ(layers.size(), 10u);
  EXPECT_EQ(layers.front(), 5);  // the middle of the first is z = 5, between nodes 4 and 5
}

// Random nodes: outlines are closed, their number of points is the number of crossings, and their
// area is near the mask's.
TEST(Layers, OfNoise) {
  Random random;
  for (int round = 0; round < 50; round++) {
    Lattice lattice;
    lattice.nodes = Index3(random.integer(1, 40), random.integer(1, 40), 3);
    TriDexel model(lattice);
    Removed removed;
    for (int i = 0; i < 60; i++)
      deposit(
          model,
          SweptBall(
              LatticePoint{random.in_box(0, 1).cwiseProduct(lattice.nodes.matrix().cast<double>())},
              LatticeVector(), random.uniform(0.6, 3)),
          0, {}, removed);
    const Snapshot snapshot = model.snapshot();
    const Layer layer = slice_layer(snapshot, 1);
    const std::vector<uint8_t> mask = mask_layer(snapshot, 1);
    const int nx = lattice.nodes.x(), ny = lattice.nodes.y();
    const auto at = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < nx && y < ny &&
             mask[static_cast<size_t>((ny - 1 - y) * nx + x)] != 0;
    };
    size_t crossings = 0, points = 0;
    for (int y = -1; y < ny; y++)
      for (int x = -1; x < nx; x++)
        crossings += (at(x, y) != at(x + 1, y)) + (at(x, y) != at(x, y + 1));
    for (const auto& outline : layer.outlines) {
      points += outline.size();
      EXPECT_GE(outline.size(), 4u);
      // No step is longer than a cell's diagonal.
      for (size_t i = 0; i < outline.size(); i++) {
        const auto &a = outline[i], &b = outline[(i + 1) % outline.size()];
        EXPECT_LE(std::hypot(a[0] - b[0], a[1] - b[1]), std::sqrt(2.0) + 1e-5) << random.note();
      }
    }
    EXPECT_EQ(points, crossings) << random.note();
  }
}

TEST(HeightMap, OfARampAndBackThroughAFile) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("kibori-height-" + std::to_string(getpid()) + ".png");
  GreyMap ramp{64, 48, {}};
  for (int y = 0; y < 48; y++)
    for (int x = 0; x < 64; x++) ramp.pixels.push_back(static_cast<uint16_t>(x * 900 + y * 60));
  ASSERT_TRUE(write_png_grey16(file, 64, 48, ramp.pixels).ok());
  const ReliefSize size{63, 10, 2};
  const auto mesh = read_relief(file, size, 0.5);
  std::filesystem::remove(file);
  ASSERT_TRUE(mesh.ok()) << mesh.error();
  const MeshInfo info = mesh_info(surface_of_mesh(mesh.value()));
  EXPECT_TRUE(info.manifold);
  EXPECT_NEAR(info.bounds.max.x(), 63, 1e-6);
  EXPECT_NEAR(info.bounds.max.y(), 47, 1e-6);
  const auto stock = stock_of_mesh(mesh.value(), 0.5, 1, 0, 1, false);
  ASSERT_TRUE(stock.ok());
  const HeightMap map = height_map(stock.value().model->snapshot());
  EXPECT_NEAR(map.low_mm, 2, 0.1);
  const Lattice& lattice = stock.value().model->lattice();
  for (int y = 0; y < map.height; y++)
    for (int x = 0; x < map.width; x++) {
      const uint16_t grey = map.pixels[static_cast<size_t>(y * map.width + x)];
      const Vec3 p = lattice.to_mm(LatticePoint{Vec3(x + 0.5, map.height - 1 - y + 0.5, 0)});
      const bool over = p.x() > 0 && p.x() < 63 && p.y() > 0 && p.y() < 47;
      ASSERT_EQ(grey != 0, over);
      if (!over) continue;
      const double wanted = 2 + 10 * (p.x() * 900 + (47 - p.y()) * 60) / 65535;
      EXPECT_NEAR(map.low_mm + (grey - 1) / 65534.0 * (map.high_mm - map.low_mm), wanted, 2e-3);
    }
}

Surface ball(double radius, const Vec3& centre = Vec3::Constant(40)) {
  Lattice lattice;
  lattice.nodes = Index3(80, 80, 80);
  TriDexel model(lattice);
  Removed removed;
  deposit(model, SweptBall(LatticePoint{centre}, LatticeVector(), radius), 0, {}, removed);
  return extract_surface(model.snapshot());
}

TEST(Distance, BetweenBalls) {
  const Surface a = ball(30), b = ball(20);
  const TwoSided d = two_sided_distance(a, b, 20000).value();
  EXPECT_NEAR(d.there.max, 10, 0.05);
  EXPECT_NEAR(d.there.rms, 10, 0.02);
  EXPECT_NEAR(d.back.mean, 10, 0.02);
  const TwoSided off = two_sided_distance(a, ball(30, Vec3(45, 40, 40)), 20000, 2).value();
  EXPECT_NEAR(off.max(), 5, 0.05);
  const TwoSided same = two_sided_distance(a, a, 20000).value();
  EXPECT_LT(same.max(), 1e-6);
  EXPECT_FALSE(two_sided_distance(a, Surface{}, 10).ok());
}

// Simplification and all distances use this one function. Checks it against the nearest of many
// points of the triangle.
TEST(Distance, ToTrianglesBySampling) {
  Random random;
  for (int i = 0; i < 300; i++) {
    const Vec3 a = random.in_box(-1, 1), b = random.in_box(-1, 1), c = random.in_box(-1, 1);
    const Vec3 p = random.in_box(-2, 2);
    constexpr int kSteps = 100;
    double min = 1e9;
    for (int u = 0; u <= kSteps; u++)
      for (int v = 0; u + v <= kSteps; v++)
        min = std::min(min, (p - (a + (u * (b - a) + v * (c - a)) / kSteps)).norm());
    const double d = distance_to_triangle(p, a, b, c);
    // A sample is never nearer than the triangle. One sample is within a step (sides of at most
    // 3.5) of its nearest point.
    EXPECT_LE(d, min + 1e-12) << random.note();
    EXPECT_GE(d, min - 3.5 / kSteps) << random.note();
  }
}

TEST(Distance, ToTrianglesWithoutArea) {
  Random random;
  for (int i = 0; i < 200000; i++) {
    const Vec3 a = random.in_box(-1, 1).cast<float>().cast<double>(),
               direction = random.in_box(-1, 1);
    const Vec3 b = Vec3(a + direction).cast<float>().cast<double>(),
               c = Vec3(a + random.uniform(-1, 2) * direction).cast<float>().cast<double>();
    const Vec3 p = random.in_box(-1, 1);
    // The segment that contains all three, by brute force.
    double min = 1e9;
    for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {a, c}})
      for (int k = 0; k <= 20; k++) min = std::min(min, (p - from - k / 20.0 * (to - from)).norm());
    const double d = distance_to_triangle(p, a, b, c);
    ASSERT_TRUE(d <= min + 1e-6 && d >= min - 0.2) << d << " " << min << " " << random.note();
  }
}

TEST(Simplify, StaysNearAndManifold) {
  Random random;
  const int rounds = std::getenv("KIBORI_SHORT") ? 3 : 15;
  for (int round = 0; round < rounds; round++) {
    Lattice lattice;
    lattice.nodes = Index3(60, 50, 40);
    TriDexel model(lattice);
    model.fill_block({Vec3(3, 3, 3), Vec3(57, 47, 37)}, 0);
    Removed removed;
    for (int i = 0; i < 8; i++)
      cut(model,
          SweptBall(LatticePoint{random.in_box(0, 50)}, LatticeVector{random.in_box(-10, 10)},
                    random.uniform(2, 12)),
          {}, removed);
    deposit(model, SweptBall(LatticePoint{Vec3(30, 25, 37)}, LatticeVector(), 8), 1, {}, removed);
    const Surface whole = extract_surface(model.snapshot());
    for (const double tolerance : {0.05, 0.5, 3.0}) {
      const Surface less = simplify(whole, tolerance);
      ASSERT_EQ(broken(less), "") << tolerance << " " << random.note();
      EXPECT_LT(less.triangles.size(), whole.triangles.size()) << random.note();
      const TwoSided d = two_sided_distance(whole, less, 20000).value();
      EXPECT_LE(d.max(), tolerance) << random.note();
    }
  }
  EXPECT_LT(simplify(ball(30), 0.5).triangles.size(), ball(30).triangles.size() / 10);
}

// A simplified block has exactly its eight corners and its twelve edges.
TEST(Simplify, ABlockBecomesABlock) {
  Lattice lattice;
  lattice.nodes = Index3(50, 40, 30);
  TriDexel model(lattice);
  model.fill_block({Vec3(5, 5, 5), Vec3(45, 35, 25)}, 0);
  const Surface whole = extract_surface(model.snapshot()), less = simplify(whole, 0.01);
  EXPECT_EQ(broken(less), "");
  EXPECT_LT(less.triangles.size(), 100u);
  EXPECT_NEAR(test::volume(less), 40 * 30 * 20, 40 * 30 * 20 * 1e-3);
}

// Two adjacent boxes of two materials: the border between them stays in place and straight.
TEST(Simplify, BordersOfColoursStay) {
  Lattice lattice;
  lattice.nodes = Index3(50, 30, 30);
  TriDexel model(lattice);
  model.fill_block({Vec3(5, 5, 5), Vec3(25, 25, 25)}, 0);
  Removed removed;
  deposit(model,
          SweptTool(BoxTool{Vec3(20, 20, 20)}, Pose{Vec3(35, 15, 5), Mat3::Identity()},
                    Vec3::Zero(), lattice),
          1, {}, removed);
  const Surface whole = extract_surface(model.snapshot()), less = simplify(whole, 0.2);
  EXPECT_EQ(broken(less), "");
  EXPECT_LT(less.triangles.size(), whole.triangles.size() / 20);
  double last[2] = {0, 50};
  for (const SurfaceVertex& v : whole.vertices)
    last[v.material] = v.material ? std::min(last[1], static_cast<double>(v.position[0]))
                                  : std::max(last[0], static_cast<double>(v.position[0]));
  for (const SurfaceTriangle& t : less.triangles)
    for (size_t i = 0; i < 3; i++) {
      const SurfaceVertex &a = less.vertices[t[i]], &b = less.vertices[t[(i + 1) % 3]];
      if (a.material == b.material) continue;
      const auto &red = a.material ? b : a, &green = a.material ? a : b;
      EXPECT_NEAR(static_cast<double>(red.position[0]), last[0], 0.2);
      EXPECT_NEAR(static_cast<double>(green.position[0]), last[1], 0.2);
    }
}

TriangleMesh tetrahedron(const Vec3& at) {
  TriangleMesh mesh;
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
    mesh.vertices.push_back(at + p);
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}
TriangleMesh both(TriangleMesh a, const TriangleMesh& b) {
  const auto first = static_cast<uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles)
    a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return a;
}

TEST(MeshInfo, OfTetrahedra) {
  MeshInfo info = mesh_info(surface_of_mesh(tetrahedron(Vec3(100, 0, 0))));
  EXPECT_TRUE(info.closed && info.manifold);
  EXPECT_NEAR(info.volume_mm3, 1.0 / 6, 1e-6);
  EXPECT_NEAR(info.area_mm2, 1.5 + std::sqrt(3.0) / 2, 1e-6);
  EXPECT_NEAR((info.centroid_mm - Vec3(100.25, 0.25, 0.25)).norm(), 0, 1e-5);
  EXPECT_EQ(info.components, 1u);
  // Two tetrahedra that touch in a corner: closed, but the corner has two fans of triangles.
  info = mesh_info(surface_of_mesh(both(tetrahedron(Vec3::Zero()), tetrahedron(Vec3(1, 0, 0)))));
  EXPECT_TRUE(info.closed);
  EXPECT_FALSE(info.manifold);
  EXPECT_EQ(info.components, 2u);
  EXPECT_NEAR(info.volume_mm3, 2.0 / 6, 1e-6);
  TriangleMesh open = tetrahedron(Vec3::Zero());
  open.triangles.pop_back();
  info = mesh_info(surface_of_mesh(open));
  EXPECT_FALSE(info.closed || info.manifold);
  EXPECT_EQ(info.open_edges, 3u);
  TriangleMesh twice = tetrahedron(Vec3::Zero());
  twice = both(twice, twice);
  info = mesh_info(surface_of_mesh(twice));
  EXPECT_FALSE(info.manifold);
  EXPECT_EQ(info.overfull_edges, 6u);
  EXPECT_EQ(mesh_info(Surface{}).triangles, 0u);
}

TEST(Picture, ShowsTheObjectInItsFrame) {
  const Surface surface = ball(30);
  PictureOptions options;
  options.width = 120;
  options.height = 80;
  options.samples = 8;
  for (const Look look : {Look::wood, Look::plain})
    for (const char* view : {"iso", "front", "back", "left", "right", "top", "bottom"}) {
      options.look = look;
      options.view = *view_named(view);
      options.threads = 1;
      const Image one = draw_picture(surface, {}, options).value();
      options.threads = 3;
      const Image many = draw_picture(surface, {}, options).value();
      ASSERT_EQ(one.pixels, many.pixels);
      // The ball fills 0.9 of the height, in the middle; brown, on white.
      const auto& middle = one.pixels[40 * 120 + 60];
      EXPECT_GT(middle[0], middle[2] + 10) << view;
      int brown = 0;
      for (const auto& p : one.pixels) brown += p[0] > p[2] + 10;
      EXPECT_NEAR(brown, M_PI * 36 * 36, 0.08 * M_PI * 36 * 36) << view;
      EXPECT_GT(one.pixels[0][0], 240) << view;
    }
  EXPECT_FALSE(view_named("sideways").has_value());
  EXPECT_FALSE(draw_picture(Surface{}, {}, options).ok());
  options.width = 5;
  EXPECT_FALSE(draw_picture(surface, {}, options).ok());
}

}  // namespace
}  // namespace kibori::layers_tests
