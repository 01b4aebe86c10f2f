// SPDX-License-Identifier: MIT
// Scan conversion against winding numbers summed from solid angles (van Oosterom and Strackee
// 1983).
#include <cmath>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/edit/scan_convert.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/solid/crossings.h>

#include "tests/support.h"

namespace kibori::scan_tests {
namespace {

using test::Random;

double winding_number(const TriangleMesh& mesh, const Vec3& at) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - at, b = mesh.vertices[t[1]] - at,
               c = mesh.vertices[t[2]] - at;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)),
                          la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * 3.14159265358979323846);
}

double distance_to(const TriangleMesh& mesh, const Vec3& p) {
  double best = 1e30;
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vec3 n = (b - a).cross(c - a);
    if (n.squaredNorm() > 0) {
      const Vec3 q = p - n * ((p - a).dot(n) / n.squaredNorm());
      if (n.dot((b - a).cross(q - a)) >= 0 && n.dot((c - b).cross(q - b)) >= 0 &&
          n.dot((a - c).cross(q - c)) >= 0)
        best = std::min(best, (p - q).norm());
    }
    for (const auto& [e, f] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
      const double s =
          std::clamp((p - e).dot(f - e) / std::max(1e-300, (f - e).squaredNorm()), 0.0, 1.0);
      best = std::min(best, (p - e - s * (f - e)).norm());
    }
  }
  return best;
}

bool inside(const FieldSnapshot& field, const Index3& node) {
  const int d = node[depth_index(field.axis())];
  bool in = false;
  field.for_spans(node[u_index(field.axis())], node[v_index(field.axis())], [&](const Span& s) {
    in |= s.in <= static_cast<float>(d) + 0.5f && static_cast<float>(d) + 0.5f < s.out;
  });
  return in;
}

// The boundary of a random chain of tetrahedra over shared vertices. It is closed and
// self-intersecting, with many shared edges and vertices. On a coarse grid, some coincide or are
// aligned with rays.
TriangleMesh random_soup(Random& random, bool aligned) {
  TriangleMesh mesh;
  for (int i = 0; i < 14; i++) {
    Vec3 p = random.in_box(1, 19);
    if (aligned) p = (p.array() * 2).floor() / 2;
    mesh.vertices.push_back(p);
  }
  for (int i = 0; i < 9; i++) {
    std::array<uint32_t, 4> v;
    for (auto& x : v) x = static_cast<uint32_t>(random.integer(0, 13));
    const Vec3 &a = mesh.vertices[v[0]], &b = mesh.vertices[v[1]], &c = mesh.vertices[v[2]],
               &d = mesh.vertices[v[3]];
    if ((b - a).dot((c - a).cross(d - a)) < 0) std::swap(v[0], v[1]);
    mesh.triangles.push_back({v[0], v[2], v[1]});
    mesh.triangles.push_back({v[0], v[1], v[3]});
    mesh.triangles.push_back({v[1], v[2], v[3]});
    mesh.triangles.push_back({v[2], v[0], v[3]});
  }
  return mesh;
}

TEST(Scan, SoupsAgreeWithTheWindingNumber) {
  Random random;
  int checked = 0;
  for (int trial = 0; trial < 60; trial++) {
    const bool aligned = trial % 2 == 0;
    const TriangleMesh mesh = random_soup(random, aligned);
    Lattice lattice;
    lattice.nodes = Index3(20, 21, 22);
    TriDexel model(lattice);
    const auto report = scan_convert(model, mesh, 0, {false, 1 + trial % 2});
    ASSERT_TRUE(report) << report.error();
    EXPECT_EQ(report.value().open_rays, 0)
        << "a closed surface is crossed as often inwards as outwards; " << random.note();
    for (int k = 0; k < 22; k++)
      for (int j = 0; j < 21; j++)
        for (int i = 0; i < 20; i++) {
          const Index3 node(i, j, k);
          const bool z = inside(model.field(Axis::z).view(), node);
          ASSERT_EQ(z, inside(model.field(Axis::x).view(), node))
              << "fields disagree; " << random.note();
          ASSERT_EQ(z, inside(model.field(Axis::y).view(), node))
              << "fields disagree; " << random.note();
          if ((i + j + k) % 3 != 0) continue;
          const Vec3 p(i + 0.5, j + 0.5, k + 0.5);
          if (distance_to(mesh, p) < 1e-3) continue;
          checked++;
          ASSERT_EQ(z, std::abs(winding_number(mesh, p)) > 0.5)
              << "node " << node.transpose() << "; " << random.note();
        }
  }
  EXPECT_GT(checked, 100000);
}

TEST(Scan, LongTrianglesAreCrossedAsRayByRay) {
  // The oracle asks for each ray alone. This skips the search for the first and last ray of a row.
  Random random;
  int crossed = 0;
  for (int round = 0; round < 300; round++) {
    SnappedPoint p[3];
    for (SnappedPoint& point : p) {
      // Every other round, vertices are on rays, so that edges pass through rays.
      const int64_t half = int64_t{1} << (kSnapBits - 1);
      const auto place = [&] {
        return round % 2 ? random.integer(-20, 130) * 2 * half + half
                         : int64_t{random.integer(-300000, 2000000)};
      };
      point = {place(), place(), random.uniform(-5, 5)};
    }
    if (round % 5 == 0) p[2].v = p[1].v;
    if (round % 7 == 0) p[2].u = p[1].u;
    const Axis axis = kAxes[static_cast<size_t>(round % 3)];
    using Found = std::vector<std::tuple<int, int, double, int>>;
    const auto in = [&](const RayRect& rect) {
      Found found;
      for_crossings(p[0], p[1], p[2], axis, rect, [&](int u, int v, double depth, int sign) {
        found.emplace_back(u, v, depth, sign);
      });
      return found;
    };
    const Found all = in({0, 120, 0, 120});
    crossed += static_cast<int>(all.size());
    Found one_by_one;
    for (int v = 0; v < 120; v++)
      for (int u = 0; u < 120; u++)
        for (const auto& found : in({u, u + 1, v, v + 1})) one_by_one.push_back(found);
    EXPECT_EQ(all, one_by_one) << random.note();
  }
  EXPECT_GT(crossed, 10000);
}

TEST(Scan, ABoxOnNodePlanesIsHalfOpenAndEveryFieldAgrees) {
  TriangleMesh mesh;
  for (int c = 0; c < 8; c++)
    mesh.vertices.emplace_back(c & 1 ? 6.5 : 2.5, c & 2 ? 7.5 : 1.5, c & 4 ? 5.5 : 3.5);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  Lattice lattice;
  lattice.nodes = Index3(9, 10, 11);
  TriDexel model(lattice);
  const auto report = scan_convert(model, mesh, 3);
  ASSERT_TRUE(report) << report.error();
  EXPECT_FALSE(report.value().repaired());
  int nodes = 0;
  for (int k = 0; k < 11; k++)
    for (int j = 0; j < 10; j++)
      for (int i = 0; i < 9; i++) nodes += inside(model.field(Axis::z).view(), {i, j, k}) ? 1 : 0;
  EXPECT_EQ(nodes, 4 * 6 * 2);
  // Edges that lie on two planes of nodes may count a cell too much (dexel/volume.h).
  EXPECT_NEAR(model.volume_mm3(), 4 * 6 * 2, 4 + 6 + 1e-6);
}

TEST(Scan, HolesCloseWhereTwoDirectionsAgree) {
  Random random;
  TriangleMesh mesh;  // a ball with some triangles missing
  const int rings = 24, sides = 48;
  for (int i = 0; i <= rings; i++)
    for (int j = 0; j < sides; j++) {
      const double a = 3.14159265358979 * i / rings, b = 2 * 3.14159265358979 * j / sides;
      mesh.vertices.emplace_back(20 + 15 * std::sin(a) * std::cos(b),
                                 20 + 15 * std::sin(a) * std::sin(b), 20 - 15 * std::cos(a));
    }
  int skipped = 0;
  for (int i = 0; i < rings; i++)
    for (int j = 0; j < sides; j++) {
      const auto at = [&](int r, int s) { return static_cast<uint32_t>(r * sides + s % sides); };
      if (i == 12 && j < 3) {
        skipped++;
        continue;
      }
      if (i > 0) mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      if (i < rings - 1) mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
    }
  ASSERT_EQ(skipped, 3);
  Lattice lattice;
  lattice.nodes = Index3(40, 40, 40);
  TriDexel model(lattice);
  const auto report = scan_convert(model, mesh, 0);
  ASSERT_TRUE(report) << report.error();
  EXPECT_GT(report.value().open_rays, 0);
  EXPECT_NE(report.value().warning().find("not closed"), std::string::npos);
  int wrong = 0;
  for (int k = 0; k < 40; k++)
    for (int j = 0; j < 40; j++)
      for (int i = 0; i < 40; i++) {
        const double r = (Vec3(i + 0.5, j + 0.5, k + 0.5) - Vec3::Constant(20)).norm();
        if (r < 14.5 || r > 15.1)
          wrong += inside(model.field(Axis::z).view(), {i, j, k}) != (r < 14.8) ? 1 : 0;
      }
  EXPECT_LE(wrong, 12);
}

TEST(Scan, RefusesAMeshThatIsMostlyOpen) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 1, 5}, {9, 1, 5.1}, {1, 9, 5.2}};
  mesh.triangles = {{0, 1, 2}};
  Lattice lattice;
  lattice.nodes = Index3(10, 10, 10);
  TriDexel refused(lattice), forced(lattice);
  const auto report = scan_convert(refused, mesh, 0);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().find("--force"), std::string::npos);
  EXPECT_TRUE(scan_convert(forced, mesh, 0, {true, 1}));
}

// Real meshes: nodes against winding numbers, where the mesh is closed, and agreement of the fields
// everywhere.
class RealMesh : public testing::TestWithParam<const char*> {};

TEST_P(RealMesh, AgreesWithTheWindingNumber) {
  const std::filesystem::path path =
      std::filesystem::path(KIBORI_SOURCE_DIR) / "../shared/models" / GetParam();
  if (!std::filesystem::exists(path))
    GTEST_SKIP() << "../shared/models is not here; nothing to test with";
  Result<TriangleMesh> read = read_mesh(path);
  ASSERT_TRUE(read) << read.error();
  TriangleMesh mesh = std::move(read).value();
  const Box box = mesh.bounds();
  const double scale = 60 / box.size().maxCoeff();
  for (Vec3& p : mesh.vertices) p = (p - box.min) * scale;
  Lattice lattice = make_lattice(box.size() * scale, 0.5, 1).value();
  TriDexel model(lattice);
  const auto report = scan_convert(model, mesh, 0, {true, 1});
  ASSERT_TRUE(report) << report.error();
  std::printf("%s: %zu triangles, %s\n", GetParam(), mesh.triangles.size(),
              report.value().repaired() ? report.value().warning().c_str() : "closed");
  Random random;
  int checked = 0, wrong = 0;
  for (int i = 0; i < 300000; i++) {
    const Index3 node(random.integer(0, lattice.nodes.x() - 1),
                      random.integer(0, lattice.nodes.y() - 1),
                      random.integer(0, lattice.nodes.z() - 1));
    const bool z = inside(model.field(Axis::z).view(), node);
    ASSERT_EQ(z, inside(model.field(Axis::x).view(), node)) << random.note();
    ASSERT_EQ(z, inside(model.field(Axis::y).view(), node)) << random.note();
    if (i >= 400) continue;
    const Vec3 p = lattice.to_mm(LatticePoint{node.matrix().cast<double>() + Vec3::Constant(0.5)});
    const double w = std::abs(winding_number(mesh, p));
    if (std::abs(w - 0.5) < 0.35) continue;  // near the surface, or in the mouth of a hole
    checked++;
    wrong += z != (w > 0.5) ? 1 : 0;
  }
  EXPECT_GT(checked, 150);
  EXPECT_LE(wrong, report.value().repaired() ? checked / 50 : 0) << random.note();
}

INSTANTIATE_TEST_SUITE_P(Models, RealMesh,
                         testing::Values("stanford-bunny.obj", "fandisk.obj", "rocker-arm.obj",
                                         "spot.obj", "teapot.obj"),
                         [](const auto& model) {
                           std::string name = model.param;
                           name.resize(name.find('.'));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace kibori::scan_tests
