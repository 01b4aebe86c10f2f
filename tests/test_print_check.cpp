// SPDX-License-Identifier: MIT
// Print check: shapes with known faults.
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include <kibori/report/print_check.h>
#include <kibori/edit/edit.h>
#include <kibori/solid/tool.h>
#include <kibori/surface/surface.h>

namespace kibori::print_check_tests {
namespace {

struct Areas {
  std::array<double, 4> of{};
  double all = 0;
};

Areas areas_of(const TriDexel& model, const PrintCheckOptions& options = {}) {
  const PrintCheck check(model.snapshot(), options);
  const Surface surface = extract_surface(model.snapshot());
  Areas areas;
  for (const SurfaceTriangle& t : surface.triangles) {
    const auto place = [&](uint32_t v) {
      const auto& p = surface.vertices[v].position;
      return Vec3(p[0], p[1], p[2]);
    };
    const double area = (place(t[1]) - place(t[0])).cross(place(t[2]) - place(t[0])).norm() / 2;
    areas.all += area;
    for (const uint32_t v : t)
      areas.of[static_cast<size_t>(check.at(surface.vertices[v]))] += area / 3;
  }
  return areas;
}

std::unique_ptr<TriDexel> room(const Vec3& size, double pitch) {
  Lattice lattice;
  lattice.pitch_mm = pitch;
  for (int i = 0; i < 3; i++) lattice.nodes[i] = static_cast<int>(size[i] / pitch);
  return std::make_unique<TriDexel>(lattice);
}

void put(TriDexel& model, const Vec3& size, const Vec3& tip) {
  Removed added;
  const SweptTool box(BoxTool{size}, Pose{tip, Mat3::Identity()}, Vec3::Zero(), model.lattice());
  deposit(model, box, 0, {}, added);
}

double of(const Areas& areas, PrintFault fault) { return areas.of[static_cast<size_t>(fault)]; }

TEST(PrintCheck, ABlockHasNoFaults) {
  const auto model = room(Vec3(30, 30, 30), 0.25);
  put(*model, Vec3(20, 15, 10), Vec3(15, 15, 5));
  const Areas areas = areas_of(*model);
  EXPECT_NEAR(of(areas, PrintFault::none), areas.all, 1e-9);
  EXPECT_NEAR(areas.all, 2 * (20 * 15 + 15 * 10 + 20 * 10), 0.05 * areas.all);
}

// A table: its top overhangs, except above its leg.
TEST(PrintCheck, WhatHangsIsFound) {
  const auto model = room(Vec3(30, 30, 30), 0.25);
  put(*model, Vec3(4, 4, 10), Vec3(15, 15, 5));
  put(*model, Vec3(20, 20, 5), Vec3(15, 15, 14.5));
  const Areas areas = areas_of(*model);
  EXPECT_NEAR(of(areas, PrintFault::overhang), 20 * 20 - 4 * 4, 0.06 * 384);
  EXPECT_NEAR(of(areas, PrintFault::thin), 0, 1e-9);
  // Printed upside down, only the leg's foot rises from the bed, and nothing overhangs.
  PrintCheckOptions turned;
  turned.up = -Vec3::UnitZ();
  EXPECT_NEAR(of(areas_of(*model, turned), PrintFault::overhang), 0, 1e-9);
}

// A cone that stands on its point is an overhang if its angle is large enough.
TEST(PrintCheck, WhatLeansHangsFromItsAngleOn) {
  for (const double angle : {60.0, 80.0, 100.0, 120.0}) {
    const auto model = room(Vec3(40, 40, 24), 0.2);
    Removed added;
    const SweptTool cone(Cone{angle, 30, 16}, Pose{Vec3(20, 20, 2), Mat3::Identity()}, Vec3::Zero(),
                         model->lattice());
    deposit(*model, cone, 0, {}, added);
    const double half = angle / 2 * std::acos(-1.0) / 180, wide = 16 * std::tan(half);
    if (wide > 18) continue;
    const double side = std::acos(-1.0) * wide * 16 / std::cos(half);
    const Areas areas = areas_of(*model);
    // Its side leans by half its angle from the vertical.
    EXPECT_NEAR(of(areas, PrintFault::overhang), angle / 2 > 45 ? side : 0, 0.05 * side) << angle;
  }
}

TEST(PrintCheck, ThinWallsAreFoundAndMeasured) {
  const auto model = room(Vec3(40, 30, 30), 0.2);
  put(*model, Vec3(30, 20, 5), Vec3(20, 15, 5));
  put(*model, Vec3(0.7, 16, 15), Vec3(12, 15, 9.5));  // too thin
  put(*model, Vec3(1.6, 16, 15), Vec3(26, 15, 9.5));
  const Areas areas = areas_of(*model);
  EXPECT_NEAR(of(areas, PrintFault::thin), 2 * 16 * 14.5, 0.08 * 464);
  const PrintCheck check(model->snapshot(), {});
  double thinnest = 1e30;
  for (const SurfaceVertex& v : extract_surface(model->snapshot()).vertices)
    thinnest = std::min(thinnest, check.thickness_mm(v));
  EXPECT_NEAR(thinnest, 0.7, 0.01);
}

TEST(PrintCheck, AWallOfTwoMaterialsIsOne) {
  const auto model = room(Vec3(30, 30, 30), 0.2);
  put(*model, Vec3(0.8, 16, 15), Vec3(14.6, 15, 5));
  Removed added;
  const SweptTool other(BoxTool{Vec3(0.8, 16, 15)}, Pose{Vec3(15.4, 15, 5), Mat3::Identity()},
                        Vec3::Zero(), model->lattice());
  deposit(*model, other, 1, {}, added);
  EXPECT_NEAR(of(areas_of(*model), PrintFault::thin), 0, 0.02 * areas_of(*model).all);
}

TEST(PrintCheck, LoosePiecesAreFound) {
  const auto model = room(Vec3(40, 30, 30), 0.25);
  put(*model, Vec3(20, 20, 10), Vec3(12, 15, 5));
  put(*model, Vec3(6, 6, 6), Vec3(30, 15, 5));
  const Areas areas = areas_of(*model);
  EXPECT_NEAR(of(areas, PrintFault::loose), 6 * 6 * 6, 0.1 * 216);
  EXPECT_EQ(PrintCheck(model->snapshot(), {}).pieces(), 2);
}

TEST(PrintCheck, NothingIsNoFault) {
  const auto model = room(Vec3(4, 4, 4), 0.5);
  EXPECT_EQ(PrintCheck(model->snapshot(), {}).pieces(), 0);
  EXPECT_EQ(areas_of(*model).all, 0);
}

}  // namespace
}  // namespace kibori::print_check_tests
