// SPDX-License-Identifier: MIT
// Repair of meshes: copies of faces, surfaces that face both ways, bodies that are inside out.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <kibori/geometry/mesh_repair.h>
#include <kibori/scene/stock.h>

#include "tests/support.h"

namespace kibori::mesh_repair_tests {
namespace {

// The twelve triangles of a box; every triangle has vertices of its own, as in STL.
TriangleMesh box(const Vec3& low, const Vec3& high, bool inverted = false) {
  TriangleMesh mesh;
  const auto corner = [&](int i) {
    return Vec3(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  };
  constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : kFaces)
    for (const auto& t : {std::array{f[0], f[1], f[2]}, std::array{f[0], f[2], f[3]}}) {
      const auto first = static_cast<uint32_t>(mesh.vertices.size());
      for (const int i : t) mesh.vertices.push_back(corner(i));
      if (inverted)
        mesh.triangles.push_back({first, first + 2, first + 1});
      else
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
  return mesh;
}

void add(TriangleMesh& to, const TriangleMesh& more) {
  const auto first = static_cast<uint32_t>(to.vertices.size());
  to.vertices.insert(to.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& t : more.triangles)
    to.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

void reverse_triangles(TriangleMesh& mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

// Volume of the stock that is made from a mesh. The sizes are no multiples of the pitch.
double volume_of(TriangleMesh mesh, std::string* warning = nullptr) {
  // The order of triangles does not matter.
  std::mt19937 order(7);
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), order);
  Result<MeshStock> stock = stock_of_mesh(mesh, 0.53, 1, 0, 1, false);
  EXPECT_TRUE(stock) << stock.error();
  if (!stock) return -1;
  if (warning) *warning = stock.value().warning();
  return stock.value().model->volume_mm3();
}

const Vec3 kZero = Vec3::Zero();

TEST(MeshRepair, ASoundMeshStays) {
  TriangleMesh two = box(kZero, Vec3(20, 20, 20));
  EXPECT_FALSE(repair_mesh(two));
  add(two, box(Vec3(10, 10, 10), Vec3(30, 30, 30)));  // overlaps
  EXPECT_FALSE(repair_mesh(two));
  TriangleMesh hollow = box(kZero, Vec3(20, 20, 20));
  add(hollow, box(Vec3(5, 5, 5), Vec3(15, 15, 15), true));
  EXPECT_FALSE(repair_mesh(hollow));
  EXPECT_NEAR(volume_of(hollow), 7000, 7);
  reverse_triangles(hollow);
  EXPECT_FALSE(repair_mesh(hollow));
  EXPECT_NEAR(volume_of(hollow), 7000, 7);
  // An inner wall between two boxes that share a face.
  TriangleMesh wall = box(kZero, Vec3(10, 20, 20));
  add(wall, box(Vec3(10, 0, 0), Vec3(20, 20, 20)));
  EXPECT_FALSE(repair_mesh(wall));
  EXPECT_NEAR(volume_of(wall), 8000, 8);
}

TEST(MeshRepair, CopiesCountOnce) {
  const TriangleMesh one = box(kZero, Vec3(20, 20, 20));
  TriangleMesh twice = one;
  add(twice, one);
  EXPECT_EQ(repair_mesh(twice)->copies, 12u);
  EXPECT_NEAR(volume_of(twice), 8000, 8);
  for (size_t face = 0; face < 6; face++)
    for (const bool reversed : {false, true}) {
      SCOPED_TRACE(testing::Message() << face << " " << reversed);
      TriangleMesh doubled = one, copy = one;
      copy.triangles = {one.triangles[2 * face], one.triangles[2 * face + 1]};
      if (reversed) reverse_triangles(copy);
      add(doubled, copy);
      std::string warning;
      EXPECT_NEAR(volume_of(doubled, &warning), 8000, 8);
      EXPECT_EQ(warning, "2 triangles are left out because others are in the same place");
    }
}

TEST(MeshRepair, SurfacesThatFaceBothWaysAreBodies) {
  const TriangleMesh one = box(kZero, Vec3(20, 20, 20));
  TriangleMesh both = one, other = one;
  reverse_triangles(other);
  add(both, other);
  EXPECT_NEAR(volume_of(both), 8000, 8);
  // Next to a sound body.
  add(both, box(Vec3(30, 0, 0), Vec3(40, 10, 10)));
  EXPECT_NEAR(volume_of(both), 9000, 9);
}

TEST(MeshRepair, InvertedBodiesAreTurned) {
  const TriangleMesh one = box(kZero, Vec3(20, 20, 20));
  TriangleMesh overlap = one;
  add(overlap, box(Vec3(10, 10, 10), Vec3(30, 20.5, 20.5), true));
  std::string warning;
  const double whole = 8000 + 20 * 10.5 * 10.5 - 10 * 10 * 10;
  EXPECT_NEAR(volume_of(overlap, &warning), whole, 0.001 * whole);
  EXPECT_EQ(warning, "1 body is reversed because it faces inwards");
  TriangleMesh apart = one;
  add(apart, box(Vec3(30, 0, 0), Vec3(40, 10, 10), true));
  EXPECT_NEAR(volume_of(apart), 9000, 9);
}

}  // namespace
}  // namespace kibori::mesh_repair_tests
