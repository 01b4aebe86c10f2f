// SPDX-License-Identifier: MIT
// Masses and centres of gravity against closed forms.
#include <cmath>

#include <gtest/gtest.h>

#include <kibori/edit/edit.h>
#include <kibori/haptics/materials.h>
#include <kibori/measure/mass.h>
#include <kibori/solid/tool.h>

#include "tests/support.h"

namespace kibori::mass_tests {
namespace {

TEST(Mass, ABlockAndABallAreAsTheyAreWorkedOut) {
  TriDexel model(make_lattice(Vec3(30, 20, 10), 0.5, 3).value());
  model.fill_block({Vec3(0, 0, 0), Vec3(30, 20, 10)}, 0);
  MassProperties all = mass_of(model.snapshot(), {500});
  EXPECT_NEAR(all.volume_mm3[0], 6000, 1e-6);
  EXPECT_NEAR(all.mass_g, 3, 1e-9);
  EXPECT_LT((all.centre_mm - Vec3(15, 10, 5)).norm(), 1e-9);

  // Minus a ball at another place.
  const double radius = 4, ball = 4.0 / 3 * std::acos(-1.0) * radius * radius * radius;
  Removed removed;
  cut(model,
      SweptTool(BallTool{radius}, {Vec3(20, 9, 1), Mat3::Identity()}, Vec3::Zero(),
                model.lattice()),
      {}, removed);
  all = mass_of(model.snapshot(), {500});
  EXPECT_NEAR(all.volume_mm3[0], 6000 - ball, 0.01 * ball);
  EXPECT_NEAR(all.volume_mm3[0], model.volume_mm3(), 1e-6);
  const Vec3 centre = (6000 * Vec3(15, 10, 5) - ball * Vec3(20, 9, 5)) / (6000 - ball);
  EXPECT_LT((all.centre_mm - centre).norm(), 5e-3);
}

TEST(Mass, EachMaterialWeighsAsItDoes) {
  TriDexel model(make_lattice(Vec3(20, 10, 10), 0.5, 1).value());
  model.fill_block({Vec3(0, 0, 0), Vec3(10, 10, 10)}, 0);
  Removed added;
  deposit(model,
          SweptTool(BoxTool{Vec3(10, 10, 10)}, {Vec3(15, 5, 0), Mat3::Identity()}, Vec3::Zero(),
                    model.lattice()),
          1, {}, added);
  const MassProperties all = mass_of(model.snapshot(), {300, 900});
  EXPECT_NEAR(all.volume_mm3[0], 1000, 1e-6);
  EXPECT_NEAR(all.volume_mm3[1], 1000, 1e-6);
  EXPECT_NEAR(all.mass_g, 1.2, 1e-9);
  EXPECT_NEAR(all.centre_mm.x(), (0.3 * 5 + 0.9 * 15) / 1.2, 1e-9);
  // An unknown density: no mass, and the centre of the volume.
  const MassProperties half = mass_of(model.snapshot(), {300, 0});
  EXPECT_EQ(half.mass_g, 0);
  EXPECT_NEAR(half.centre_mm.x(), 10, 1e-9);
}

TEST(Mass, WhatIsEmptyWeighsNothing) {
  const TriDexel model(make_lattice(Vec3(3, 1, 1), 1, 0).value());
  const MassProperties all = mass_of(model.snapshot(), {300});
  EXPECT_EQ(all.mass_g, 0);
  EXPECT_EQ(all.centre_mm, Vec3(0, 0, 0));
  EXPECT_EQ(known_material("oak")->density_kg_m3, 720);
  EXPECT_EQ(known_material("unobtainium"), nullptr);
}

}  // namespace
}  // namespace kibori::mass_tests
