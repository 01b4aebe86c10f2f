// SPDX-License-Identifier: MIT
// Forces of wood with grain: against closed forms and against dense sampling of the removed wood,
// in any direction and place. Also what grain must not change.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/edit/grain.h>
#include <kibori/haptics/materials.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/spring_tool.h>

#include "tests/support.h"

namespace kibori::grain_tests {
namespace {

using test::Random;

constexpr double kU = 20, kAlong = 8;

Material wood(double u_along, double ring) {
  Material m;
  m.u = kU;
  m.u_along = u_along;
  m.ring = ring;
  return m;
}

TriDexel block(const Vec3& size, double pitch) {
  TriDexel model(make_lattice(size, pitch, 2).value());
  model.fill_block({Vec3::Zero(), size}, 0);
  return model;
}

ForceLaw energy() {
  ForceLaw law;
  law.model = ForceModel::energy;
  return law;
}

TEST(Grain, TheMeanOfARingMatchesItsMaterial) {
  double sum = 0;
  constexpr int kSamples = 400000;
  for (int i = 0; i < kSamples; i++) sum += late_wood((i + 0.5) * 400 / kSamples);
  EXPECT_NEAR(sum / kSamples, kMeanLate, 0.001);
}

// A box moves through the wood below its surface. Its force is u(theta) times its front area.
TEST(Grain, AlongAndAcrossAreHankinsons) {
  const double pi = std::numbers::pi;
  for (int i = 0; i <= 12; i++) {
    const double turn = i * pi / 24, lean = (i % 3) * 0.2;  // of the path, and of the grain
    TriDexel model = block(Vec3(40, 40, 20), 0.5);
    const std::vector<Material> materials{wood(kAlong, 0)};
    Log log;
    log.along = Vec3(std::cos(lean), 0, std::sin(lean));
    const Grain grain(log, model.lattice(), materials);
    const Vec3 direction(std::cos(turn), std::sin(turn), 0);
    const Vec3 start(12, 12, 8);
    DirectTool tool(model, {start, frame_from_axis(Vec3::UnitZ(), turn)});
    tool.set_grain(&grain);
    const Tool box = BoxTool{Vec3(4, 6, 5)};
    const auto pull = [&](DirectTool& by, const std::vector<Material>& of) {
      // The first tick removes the volume that the tool occupies.
      EXPECT_TRUE(
          by.advance(box, start + 0.5 * direction, Vec3::Zero(), Mode::cut, energy(), of).ok());
      const auto tick =
          by.advance(box, start + 3 * direction, Vec3::Zero(), Mode::cut, energy(), of);
      EXPECT_TRUE(tick.ok());
      return tick.value().wrench.force;
    };
    const double cos = direction.dot(log.along), sin2 = 1 - cos * cos;
    const double u = kAlong * kU / (kAlong * sin2 + kU * cos * cos);
    const Vec3 pulled = pull(tool, materials);
    const double force = pulled.norm();
    // For an oblique face, the volumes of the fields are wrong by up to a percent.
    EXPECT_NEAR(force, u * 6 * 5, 0.015 * u * 30) << i;
    // It acts against the motion.
    EXPECT_NEAR(pulled.dot(direction), -force, 1e-9 * force);
    TriDexel same = block(Vec3(40, 40, 20), 0.5);
    DirectTool plain(same, {start, frame_from_axis(Vec3::UnitZ(), turn)});
    EXPECT_NEAR(force / pull(plain, {wood(0, 0)}).norm(), u / kU, 1e-5) << i;
  }
}

// Random tools, paths and logs. The work over the path is the integral of u over the removed
// volume. It is sampled in cells of a fifth.
TEST(Grain, RingsResistWhereTheyAre) {
  Random random;
  for (int trial = 0; trial < 12; trial++) {
    SCOPED_TRACE(random.note());
    TriDexel model = block(Vec3(24, 22, 16), 0.25);
    const std::vector<Material> materials{wood(random.uniform(4, 20), random.uniform(0.5, 4))};
    Log log;
    log.pith = random.in_box(-20, 40);
    log.along = random.direction();
    log.ring = random.uniform(2.5, 6);
    const Grain grain(log, model.lattice(), materials);
    const double radius = random.uniform(3, 5);
    const Vec3 start = random.in_box(6, 14), direction = random.direction() * random.uniform(3, 6);
    DirectTool tool(model, {start - Vec3(0, 0, radius), frame_from_axis(Vec3::UnitZ())});
    tool.set_grain(&grain);
    const auto tick = tool.advance(BallTool{radius}, start - Vec3(0, 0, radius) + direction,
                                   Vec3::Zero(), Mode::cut, energy(), materials);
    ASSERT_TRUE(tick.ok());
    // The same cut in plain wood: it shares the discretisation error of the ball's volume.
    TriDexel same = block(Vec3(24, 22, 16), 0.25);
    DirectTool plain(same, {start - Vec3(0, 0, radius), frame_from_axis(Vec3::UnitZ())});
    const auto without_grain =
        plain.advance(BallTool{radius}, start - Vec3(0, 0, radius) + direction, Vec3::Zero(),
                      Mode::cut, energy(), {wood(0, 0)});
    ASSERT_TRUE(without_grain.ok());
    // The volume that the ball occupies at its start causes no force (DirectTool::measure_start).
    double sum = 0, volume = 0;
    constexpr double kStep = 0.1;
    const double cos = direction.dot(log.along) / direction.norm(), along = materials[0].u_along;
    const double u = along * kU / (along * (1 - cos * cos) + kU * cos * cos);
    for (double z = kStep / 2; z < 16; z += kStep)
      for (double y = kStep / 2; y < 22; y += kStep)
        for (double x = kStep / 2; x < 24; x += kStep) {
          const Vec3 p = Vec3(x, y, z) - start;
          const double s = std::clamp(p.dot(direction) / direction.squaredNorm(), 0.0, 1.0);
          if ((p - s * direction).norm() >= radius || p.norm() < radius) continue;
          const Vec3 at(x, y, z);
          sum += u * (1 + materials[0].ring *
                              (late_wood(rings_at(log, at, ring_wave(log, at))) - kMeanLate));
          volume++;
        }
    if (volume < 2000) continue;
    const double expected = sum / volume / kU;
    EXPECT_NEAR(tick.value().wrench.force.norm() / without_grain.value().wrench.force.norm(),
                expected, 0.01 * expected);
  }
}

// A small turn of the path or a small step aside causes no jump.
TEST(Grain, ForceIsContinuousInDirectionAndPlace) {
  const std::vector<Material> materials{wood(kAlong, 1)};
  const auto force_of = [&](double turn, double aside) {
    TriDexel model = block(Vec3(30, 30, 12), 0.5);
    const std::shared_ptr<const Grain> grain = Grain::of(model.lattice(), materials);
    EXPECT_TRUE(grain);
    const Vec3 direction(std::cos(turn), std::sin(turn), 0), start(8, 8 + aside, 4);
    DirectTool tool(model, {start, frame_from_axis(Vec3::UnitZ(), turn)});
    tool.set_grain(grain.get());
    const auto tick = tool.advance(BallTool{3}, start + 6 * direction, Vec3::Zero(), Mode::cut,
                                   energy(), materials);
    EXPECT_TRUE(tick.ok());
    return tick.value().wrench.force.norm();
  };
  double last = force_of(0.2, 0);
  for (int i = 1; i <= 30; i++) {
    const double now = force_of(0.2 + 0.01 * i, 0);
    EXPECT_NEAR(now, last, 0.02 * last) << i;
    last = now;
  }
  last = force_of(0.2, 0);
  for (int i = 1; i <= 30; i++) {
    const double now = force_of(0.2, 0.05 * i);
    EXPECT_NEAR(now, last, 0.03 * last) << i;
    last = now;
  }
}

// A grain whose resistance is equal in all directions changes no force and no moment. Also if the
// tool turns, and in several materials.
TEST(Grain, WithoutADifferenceForcesAreThoseOfPlainWood) {
  Random random;
  for (int trial = 0; trial < 30; trial++) {
    SCOPED_TRACE(random.note());
    const std::vector<Material> plain{wood(0, 0), wood(0, 0)},
        grained{wood(kU * (1 + 1e-13), 0), wood(kU * (1 + 1e-13), 0)};
    TriDexel a = block(Vec3(20, 18, 14), 0.5), b = block(Vec3(20, 18, 14), 0.5);
    const std::shared_ptr<const Grain> grain = Grain::of(b.lattice(), grained);
    ASSERT_TRUE(grain);
    const Pose start{random.in_box(4, 14), frame_from_axis(random.direction())};
    DirectTool first(a, start), second(b, start);
    second.set_grain(grain.get());
    ForceLaw law = energy();
    law.dof = trial % 2 ? 5 : 6;
    Vec3 tip = start.tip;
    for (int i = 0; i < 6; i++) {
      tip += random.direction();
      const Vec3 turn = trial % 3 == 0 ? Vec3(random.direction() * 0.1) : Vec3(Vec3::Zero());
      const Mode mode = i % 3 == 1 ? Mode::deposit : i % 3 == 2 ? Mode::touch : Mode::cut;
      const Tool tool = Flat{2, 9};
      const auto one = first.advance(tool, tip, turn, mode, law, plain, 1),
                 other = second.advance(tool, tip, turn, mode, law, grained, 1);
      ASSERT_TRUE(one.ok() && other.ok());
      const Wrench &u = one.value().wrench, &v = other.value().wrench;
      // Sums of vectors are float32 within a tile.
      EXPECT_LT((u.force - v.force).norm(), 1e-4 * (1 + u.force.norm()));
      EXPECT_LT((u.moment - v.moment).norm(), 1e-4 * (1 + u.moment.norm()));
      EXPECT_EQ(a.content_hash(), b.content_hash());
    }
  }
}

// A deposit resists as its own wood, also next to another wood.
TEST(Grain, ADepositResistsAsItsOwnWood) {
  for (const bool next_to_grain : {false, true}) {
    const Material put = wood(kU * (1 + 1e-13), 0), there = next_to_grain ? wood(4, 3) : wood(0, 0);
    const std::vector<Material> materials{there, put};
    TriDexel model(make_lattice(Vec3(30, 20, 20), 0.5, 6).value());
    model.fill_block({Vec3::Zero(), Vec3(30, 20, 12)}, 0);
    const std::shared_ptr<const Grain> grain = Grain::of(model.lattice(), materials);
    DirectTool tool(model, {Vec3(8, 10, 9), frame_from_axis(Vec3::UnitZ())});
    tool.set_grain(grain.get());
    const auto tick = tool.advance(BoxTool{Vec3(4, 6, 8)}, Vec3(12, 10, 9), Vec3::Zero(),
                                   Mode::deposit, energy(), materials, 1);
    ASSERT_TRUE(tick.ok());
    // 5 of its 8 mm are above the wood. Its path has 8 cells, and the force of the last half cell
    // is still pending.
    EXPECT_NEAR(tick.value().wrench.force.norm(), kU * 6 * 5 * (1 - 0.5 / 8), 0.02 * kU * 30)
        << next_to_grain;
  }
}

// A hand that drives a tool on a spring needs less force along the grain than across it.
TEST(Grain, TheSpringTransmitsTheGrain) {
  const auto pull = [](const Vec3& direction) {
    TriDexel model = block(Vec3(60, 60, 14), 0.5);
    const std::vector<Material> materials{wood(kU / 2, 0)};
    Log log;
    log.along = Vec3::UnitX();
    const Grain grain(log, model.lattice(), materials);
    SeriesSpring spring;
    spring.stiffness_n_mm = 400;
    spring.friction = 0;
    const Vec3 start = Vec3(30, 30, 12) - 34 * direction;
    SpringTool tool(model, {start, frame_from_axis(Vec3::UnitZ())}, spring);
    tool.set_grain(&grain);
    double sum = 0;
    int count = 0;
    for (int i = 1; i <= 500; i++) {
      const auto tick =
          tool.advance(Flat{3, 10}, {start + 0.1 * i * direction, frame_from_axis(Vec3::UnitZ())},
                       Mode::cut, materials);
      EXPECT_TRUE(tick.ok());
      if (i < 200) continue;
      sum += tick.value().wrench.force.norm();
      count++;
    }
    return sum / count;
  };
  const double along = pull(Vec3::UnitX()), across = pull(Vec3::UnitY());
  EXPECT_NEAR(across / along, 2, 0.04);
  EXPECT_NEAR(across, kU * 6 * 2, 0.03 * across);
}

TEST(Grain, KnownMaterialsAreSound) {
  for (const Material& material : known_materials()) {
    EXPECT_EQ(fault_of(material), nullptr) << material.name;
    EXPECT_GT(material.density_kg_m3, 0) << material.name;
    const auto [end, along, across] = material.k;
    // End grain needs more force than along the fibres, and that at least as much as across.
    EXPECT_EQ(has_grain(material), end > along || material.ring > 0) << material.name;
    EXPECT_GE(end, along) << material.name;
    EXPECT_GE(along, across) << material.name;
    EXPECT_EQ(material.m, has_chip_law(material) ? 0.5 : 0) << material.name;
  }
  EXPECT_FALSE(Grain::of(make_lattice(Vec3(10, 10, 10), 1, 1).value(), {Material{}}));
}

// The mean share of late wood over pieces of rays, of any length and axis, near the pith and far
// from it. The oracle samples the wood densely. Each vector lane is independent of its neighbours.
TEST(Grain, MeansOverPiecesAreThoseOfTheWood) {
  Random random;
  double worst = 0;
  for (int trial = 0; trial < 200; trial++) {
    SCOPED_TRACE(random.note());
    const Lattice lattice = make_lattice(Vec3(40, 30, 25), 0.5, 1).value();
    Log log;
    log.pith = random.in_box(-10, 50);
    log.along = random.direction();
    log.ring = random.uniform(1.5, 5);
    const Grain grain(log, lattice, {wood(kAlong, 1)});
    const Axis axis = kAxes[static_cast<size_t>(trial % 3)];
    const double depth = lattice.nodes[depth_index(axis)];
    const float u = static_cast<float>(random.uniform(0, 20)),
                v = static_cast<float>(random.uniform(0, 40));
    float lo[16], hi[16], means[16];
    for (int i = 0; i < 16; i++) {
      lo[i] = static_cast<float>(random.uniform(0, 0.7 * depth));
      hi[i] = lo[i] + static_cast<float>(random.uniform(0, 1) * random.uniform(0, 0.3 * depth));
    }
    grain.late_wood_of(axis, u, v, lo, hi, 16, means);
    for (int i = 0; i < 16; i++) {
      Vec3 at;
      at[u_index(axis)] = u + static_cast<float>(i);
      at[v_index(axis)] = v;
      const auto late = [&](double t) {
        at[depth_index(axis)] = t;
        const Vec3 mm = lattice.to_mm(LatticePoint{at});
        return late_wood(rings_at(log, mm, ring_wave(log, mm)));
      };
      double sum = 0;
      constexpr int kSamples = 400;
      for (int k = 0; k < kSamples; k++)
        sum += late(lo[i] + (hi[i] - lo[i]) * (k + 0.5) / kSamples);
      const double rings = (hi[i] - lo[i]) * lattice.pitch_mm / log.ring;
      // The waves of the rings have an error of a few hundredths of a ring. At either end of a
      // piece, this adds or removes late wood. Near the pith, the ring width varies within a piece.
      const double error = std::abs(means[i] - sum / kSamples);
      if (rings > 0.2) {
        EXPECT_LT(error, 0.02 + 0.04 / rings) << rings;
      }
      worst = std::max(worst, error * std::min(rings, 1.0));
    }
    // The result for one piece does not depend on the other pieces of its row.
    float alone[16], same[16], again[16];
    std::fill_n(alone, 16, lo[0]);
    std::fill_n(same, 16, hi[0]);
    grain.late_wood_of(axis, u, v, alone, same, 16, again);
    EXPECT_EQ(again[0], means[0]);
  }
  std::printf("mean late wood over pieces: off by %.3f at most, over a ring or more\n", worst);
}

// The grid of the waves covers lattices of any shape: one cell, flat, long.
TEST(Grain, AnyLatticeHasPlacesForAllOfIt) {
  Random random;
  for (const Vec3& size : {Vec3(1, 1, 1), Vec3(100, 1, 1), Vec3(1, 200, 3), Vec3(70, 60, 2)}) {
    const Lattice lattice = make_lattice(size, 1, 0.5).value();
    const std::vector<Material> materials{wood(kAlong, 2)};
    const Log log = log_of(lattice.to_mm(lattice.whole()));
    const Grain grain(log, lattice, materials);
    for (int i = 0; i < 200; i++) {
      const Vec3 at = random.in_box(0, 1).cwiseProduct(lattice.nodes.matrix().cast<double>());
      const Vec3 mm = lattice.to_mm(LatticePoint{at});
      // The same short piece on 16 rays. Only the first ray is checked.
      float lo[16], hi[16], means[16];
      std::fill_n(lo, 16, static_cast<float>(at[2] - 1e-6));
      std::fill_n(hi, 16, static_cast<float>(at[2] + 1e-6));
      grain.late_wood_of(Axis::z, static_cast<float>(at[u_index(Axis::z)]),
                         static_cast<float>(at[v_index(Axis::z)]), lo, hi, 16, means);
      const double here = 1 + 2 * (static_cast<double>(means[0]) - kMeanLate);
      // The waves come from a coarse grid: the error is a few hundredths of a ring at most.
      double low = 1e9, high = -1e9;
      for (int k = -20; k <= 20; k++) {
        const double value =
            1 + 2 * (late_wood(rings_at(log, mm, ring_wave(log, mm)) + 0.003 * k) - kMeanLate);
        low = std::min(low, value);
        high = std::max(high, value);
      }
      EXPECT_GE(here, low - 0.06) << random.note();
      EXPECT_LE(here, high + 0.06) << random.note();
    }
  }
}

}  // namespace
}  // namespace kibori::grain_tests
