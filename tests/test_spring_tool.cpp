// SPDX-License-Identifier: MIT
// The series tool against closed forms: its force, what it cuts, and what it does not cut.
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/base/percent.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/spring_tool.h>

#include "tests/support.h"

namespace kibori::spring_tool_tests {
namespace {

using test::Random;

constexpr double kPi = 3.14159265358979;

Material wood() {
  Material m;
  m.u = 0.2;
  m.yield_n = 0.3;
  m.c = 0;
  return m;
}

// A block of 40 x 30 x 20 mm with room around.
TriDexel block(double pitch) {
  const Lattice lattice = make_lattice(Vec3(40, 30, 20), pitch, 10).value();
  TriDexel model(lattice);
  model.fill_block({Vec3::Zero(), Vec3(40, 30, 20)}, 0);
  return model;
}

Pose upright(const Vec3& tip) { return {tip, Mat3::Identity()}; }

double length(const Vec3& v) { return std::sqrt(v.squaredNorm()); }

TEST(Rotation, BetweenFrames) {
  Random random;
  for (int i = 0; i < 1000; i++) {
    const Mat3 from = frame_from_axis(random.direction(), random.uniform(-3, 3));
    const Vec3 turn =
        random.direction() * (i % 10 == 0 ? kPi : std::pow(10, random.uniform(-12, 0.49)));
    const Mat3 to = rotation(turn) * from;
    const Vec3 back = rotation_between(from, to);
    EXPECT_LT((rotation(back) * from - to).norm(), 1e-7) << random.note();
    EXPECT_LT(length(back), kPi + 1e-9) << random.note();
  }
}

// The hand has limited strength and jumps far from the tool, as when a wall releases the tool. Then
// it rests. The tool reaches it within the number of ticks that its look-ahead needs.
TEST(SpringTool, FarBehindItArrives) {
  TriDexel model = block(0.25);
  const std::vector<Material> materials{wood()};
  SeriesSpring spring;
  spring.strength_n = 200;
  spring.stiffness_n_mm = 800;
  for (const Tool& hand_tool : {Tool(BallTool{4}), Tool(Bull{4, 1.5, 24}), Tool(Flat{3, 20})})
    for (const double lean : {0.0, 1.3}) {
      SpringTool tool(model, upright({0, 15, 25}), spring);
      Pose device = upright({0, 15, 25});
      ASSERT_TRUE(tool.advance(hand_tool, device, Mode::cut, materials).ok());  // it is clear here
      device.tip.x() = 38;
      device.frame = frame_from_axis(Vec3(0, -std::sin(lean), std::cos(lean)));
      int ticks = 0;
      while ((tool.pose().tip != device.tip ||
              rotation_between(tool.pose().frame, device.frame).norm() > 1e-6) &&
             ticks < 400) {
        ASSERT_TRUE(tool.advance(hand_tool, device, Mode::cut, materials).ok());
        ticks++;
      }
      EXPECT_LT(ticks, 400) << shape_of(hand_tool) << " leaning by " << lean;
    }
  EXPECT_EQ(model.volume_mm3(), 40 * 30 * 20);
  // In wood, the same jump leaves the groove of a single pass. The depth is small enough for the
  // strength of the hand.
  SpringTool tool(model, upright({-6, 15, 19}), spring);
  ASSERT_TRUE(tool.advance(BallTool{4}, upright({-6, 15, 19}), Mode::cut, materials).ok());
  double removed = 0;
  for (int i = 0; i < 100; i++) {
    const auto result = tool.advance(BallTool{4}, upright({46, 15, 19}), Mode::cut, materials);
    ASSERT_TRUE(result.ok());
    removed += result.value().removed_mm3;
  }
  const double segment = 16 * std::acos(0.75) - 3 * std::sqrt(7.0);
  EXPECT_NEAR(removed, 40 * segment, 0.02 * 40 * segment);  // some 60 rays measure its area
  // In the last tick, the cut's resistance of at most 10 N stretches the spring of 800 N/mm.
  EXPECT_LT((tool.pose().tip - Vec3(46, 15, 19)).norm(), 10.0 / 800);
}

TEST(SpringTool, FreeAirIsFree) {
  TriDexel model = block(0.5);
  SpringTool tool(model, upright({20, 15, 25}), {});
  const std::vector<Material> materials{wood()};
  for (int i = 0; i < 100; i++) {
    const Pose device = upright({20 + 0.1 * i, 15, 25});
    const auto result = tool.advance(BallTool{3}, device, Mode::cut, materials);
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(length(result.value().wrench.force), 0);
    EXPECT_EQ(result.value().removed_mm3, 0);
    EXPECT_EQ(result.value().pose.tip, device.tip);
  }
}

TEST(SpringTool, BelowYieldNothingIsCut) {
  TriDexel model = block(0.5);
  const double before = model.volume_mm3();
  SeriesSpring spring;
  spring.stiffness_n_mm = 1;
  SpringTool tool(model, upright({20, 15, 21}), spring);
  const std::vector<Material> materials{wood()};
  double last = 0;
  for (int i = 0; i <= 1280; i++) {
    const double z = 21 - 0.001 * i;  // 0.28 mm into the face: 0.28 N of 0.3
    const auto result = tool.advance(Flat{3, 30}, upright({20, 15, z}), Mode::cut, materials);
    ASSERT_TRUE(result.ok());
    EXPECT_FALSE(result.value().cutting);
    const double force = result.value().wrench.force.z();
    EXPECT_NEAR(force, z < 20 ? spring.stiffness_n_mm * (20 - z) : 0, 2e-3);
    EXPECT_LE(std::abs(force - last), 0.002);  // no jump at the touch
    last = force;
  }
  EXPECT_EQ(model.volume_mm3(), before);
}

TEST(SpringTool, PlungeOfAFlatHasYieldEnergyAndViscosity) {
  for (const double viscosity : {0.0, 0.002}) {
    TriDexel model = block(0.25);
    SeriesSpring spring;
    spring.stiffness_n_mm = 2;
    SpringTool tool(model, upright({20, 15, 20.05}), spring);
    std::vector<Material> materials{wood()};
    materials[0].c = viscosity;
    const double area = kPi * 9, speed = 10;
    const double expected = materials[0].yield_n + materials[0].u * area + viscosity * area * speed;
    Vec3 force = Vec3::Zero();
    double volume = 0, depth = 0;
    for (int i = 0; i < 1200; i++) {
      const auto result = tool.advance(Flat{3, 30}, upright({20, 15, 20.05 - 0.001 * speed * i}),
                                       Mode::cut, materials);
      ASSERT_TRUE(result.ok());
      force = result.value().wrench.force;
      volume += result.value().removed_mm3;
      depth = 20 - result.value().pose.tip.z();
      if (i > 600) {
        EXPECT_NEAR(force.z(), expected, 0.012 * expected);  // 12 cells measure the disc to 0.9 %
      }
    }
    EXPECT_NEAR(force.x(), 0, 1e-6);
    EXPECT_GT(depth, 2);
    EXPECT_NEAR(volume, area * depth, 0.01 * area * depth);
  }
}

// Root mean square of the ripple over the mean, in the steady part of a scrape.
double ripple(const std::vector<double>& force) {
  const auto from = force.begin() + static_cast<long>(force.size() / 2);
  const double n = static_cast<double>(force.end() - from),
               mean = std::accumulate(from, force.end(), 0.0) / n;
  double sum = 0;
  for (auto f = from; f != force.end(); f++) sum += (*f - mean) * (*f - mean);
  return std::sqrt(sum / n) / mean;
}

TEST(SpringTool, RipplesLittleWhereThePaperModelRipplesMuch) {
  const double speed = 10, depth = 1.5;
  const Finger finger{0.5, 30};
  std::vector<Material> materials{wood()};
  std::vector<double> series, paper;
  {
    TriDexel model = block(0.25);
    SpringTool tool(model, upright({-4, 15, 20 - depth}), {1.0, 0, 0.2, 0.001});
    for (int i = 0; i < 3000; i++) {
      const auto result = tool.advance(finger, upright({-4 + 0.001 * speed * i, 15, 20 - depth}),
                                       Mode::cut, materials);
      ASSERT_TRUE(result.ok());
      series.push_back(length(result.value().wrench.force));
    }
  }
  {
    TriDexel model = block(0.25);
    DirectTool stroke(model, upright({-4, 15, 20 - depth}));
    for (int i = 0; i < 3000; i++) {
      const auto tick = stroke.advance(finger, {-4 + 0.001 * speed * i, 15, 20 - depth},
                                       Vec3::Zero(), Mode::cut, {ForceModel::paper, 6}, materials);
      ASSERT_TRUE(tick.ok());
      paper.push_back(length(tick.value().wrench.force));
    }
  }
  std::printf("ripple: series %s, paper %s of the mean\n", percent(ripple(series)).c_str(),
              percent(ripple(paper)).c_str());
  EXPECT_LT(ripple(series), 0.05);
  EXPECT_GT(ripple(paper), 0.2);
}

TEST(SpringTool, DoesNotDependOnThePitch) {
  // A ball of radius 5 mm: 20 and 40 cells.
  double mean[2] = {};
  for (const int fine : {0, 1}) {
    TriDexel model = block(fine ? 0.125 : 0.25);
    SpringTool tool(model, upright({-6, 15, 18}), {1.0, 0, 0.2, 0.001});
    const std::vector<Material> materials{wood()};
    double sum = 0;
    for (int i = 0; i < 2400; i++) {
      const auto result =
          tool.advance(BallTool{5}, upright({-6 + 0.01 * i, 15, 18}), Mode::cut, materials);
      ASSERT_TRUE(result.ok());
      if (i >= 1600) sum += length(result.value().wrench.force) / 800;
    }
    mean[fine] = sum;
  }
  std::printf("mean force at 20 and 40 cells of radius: %.4f, %.4f N\n", mean[0], mean[1]);
  EXPECT_NEAR(mean[0] / mean[1], 1, 0.05);
}

TEST(SpringTool, TakesWorkFromTheHandAlways) {
  Random random;
  for (int round = 0; round < 20; round++) {
    TriDexel model = block(0.5);
    const Tool tools[] = {BallTool{3}, Finger{0.3, 20}, Flat{2, 20}, Capsule{2, 15}};
    const Tool& shape = tools[round % 4];
    Pose device = upright({20, 15, 22});
    SpringTool tool(model, device, {1.0, round % 2 ? 500.0 : 0.0, 0.2, 0.001});
    const std::vector<Material> materials{wood()};
    Vec3 velocity = Vec3::Zero();
    double removed = 0;
    const double before = model.volume_mm3();
    for (int i = 0; i < 400; i++) {
      velocity =
          0.95 * velocity + 0.01 * random.in_box(-1, 1) + 0.002 * (Vec3(20, 15, 17) - device.tip);
      device.tip += velocity;
      device.frame = rotation(random.in_box(-0.01, 0.01)) * device.frame;
      const Vec3 from = tool.pose().tip;
      const auto result = tool.advance(shape, device, Mode::cut, materials);
      ASSERT_TRUE(result.ok()) << result.error();
      // The spring only pulls the tool in the direction of its motion.
      EXPECT_LE(result.value().wrench.force.dot(result.value().pose.tip - from), 1e-9)
          << random.note();
      removed += result.value().removed_mm3;
    }
    EXPECT_NEAR(before - model.volume_mm3(), removed, 1e-6 * before) << random.note();
  }
}

TEST(SpringTool, SlidesOnAFaceBelowYield) {
  TriDexel model = block(0.25);
  SpringTool tool(model, upright({10, 15, 20.5}), {1.0, 0, 0.1, 0.001});
  std::vector<Material> materials{wood()};
  materials[0].yield_n = 50;
  Vec3 tip;
  for (int i = 0; i < 2000; i++) {
    // Down 0.8 mm into the face, then sideways.
    const Vec3 to(10 + 0.01 * std::max(0, i - 500), 15, 20.5 - std::min(1.3, 0.01 * i));
    const auto result = tool.advance(BallTool{3}, upright(to), Mode::cut, materials);
    ASSERT_TRUE(result.ok());
    EXPECT_FALSE(result.value().cutting);
    tip = result.value().pose.tip;
    if (i > 1000) {
      EXPECT_NEAR(tip.z(), 20, 0.02);
      EXPECT_NEAR(to.x() - tip.x(), 0.1 * 0.8, 0.03);  // friction holds it back by mu N / k
      EXPECT_NEAR(result.value().wrench.force.z(), 0.8, 0.03);
    }
  }
  EXPECT_EQ(model.volume_mm3(), 40 * 30 * 20);
}

TEST(SpringTool, DepositsAgainstResistance) {
  TriDexel model = block(0.5);
  SpringTool tool(model, upright({20, 15, 23}), {1.0, 0, 0.2, 0.001});
  const std::vector<Material> materials{wood()};
  const double before = model.volume_mm3();
  double added = 0;
  for (int i = 0; i < 800; i++) {
    const auto result =
        tool.advance(BallTool{2}, upright({20 + 0.01 * i, 15, 23}), Mode::deposit, materials);
    ASSERT_TRUE(result.ok());
    added -= result.value().removed_mm3;
    if (i > 600) {
      // u times the ball's cross-section.
      EXPECT_NEAR(result.value().wrench.force.x(), -0.2 * kPi * 4, 0.05 * 0.2 * kPi * 4);
      EXPECT_NEAR(result.value().wrench.force.z(), 0, 1e-6);
    }
  }
  EXPECT_GT(added, 50);
  EXPECT_NEAR(model.volume_mm3() - before, added, 1e-6 * before);
}

TEST(SpringTool, PutsItsBodyDownWhereADepositBegins) {
  for (const double distance : {0.0, 1e-4}) {
    TriDexel model = block(0.25);
    SpringTool tool(model, upright({20, 15, 23}), {1.0, 0, 0.2, 0.001});
    double added = 0;
    for (int i = 0; i < 3; i++) {
      const auto result =
          tool.advance(BallTool{2}, upright({20 + distance * i, 15, 23}), Mode::deposit, {wood()});
      ASSERT_TRUE(result.ok());
      EXPECT_EQ(result.value().edited, i == 0);
      EXPECT_LT(result.value().wrench.force.norm(), 1e-3);
      added -= result.value().removed_mm3;
    }
    EXPECT_NEAR(added, 4.0 / 3 * kPi * 8, 0.02 * 4.0 / 3 * kPi * 8);
  }
}

TEST(SpringTool, ATorsionalSpringHoldsTheTurnBack) {
  // A box with one edge in the block's side: turning it presses a face against material.
  TriDexel model = block(0.25);
  std::vector<Material> materials{wood()};
  materials[0].yield_n = 100;
  const Pose start = upright({20, -2.05, 12});  // the box's face 0.05 mm off the block's side
  SpringTool tool(model, start, {1.0, 300, 0.1, 0.001});
  double moment = 0, turned = 0;
  for (int i = 0; i <= 300; i++) {
    const double angle = 0.001 * i;
    const Pose device{start.tip, rotation(Vec3(0, 0, angle))};
    const auto result = tool.advance(BoxTool{Vec3(8, 4, 6)}, device, Mode::cut, materials);
    ASSERT_TRUE(result.ok());
    EXPECT_FALSE(result.value().cutting);
    moment = result.value().wrench.moment.z();
    turned = rotation_between(start.frame, result.value().pose.frame).z();
    EXPECT_NEAR(moment, -300 * (angle - turned), 1e-6);
  }
  // A corner 4 mm out meets the side after about 0.05/4 rad.
  EXPECT_LT(turned, 0.03);
  EXPECT_LT(moment, -300 * 0.25);
  EXPECT_EQ(model.volume_mm3(), 40 * 30 * 20);
}

// The tool moves down at 5 mm/s until it touches, yields and cuts, and then moves out again. In one
// tick, the force changes at most by the stiffness times the displacement of the hand. Where a flat
// tool meets the next layer of rays, it may change by half a percent of the maximum force.
TEST(SpringTool, TouchYieldAndReleaseAreContinuous) {
  for (const Tool& shape : {Tool(BallTool{4}), Tool(Finger{0.2, 15}), Tool(Flat{3, 15})}) {
    TriDexel model = block(0.25);
    const SeriesSpring spring{1.5, 0, 0.2, 0.001};
    SpringTool tool(model, upright({20, 15, 21}), spring);
    const std::vector<Material> materials{wood()};
    const double step = 0.005;
    double last = 0, max = 0, largest = 0;
    bool touched = false, cut = false;
    for (int i = 0; i < 3000; i++) {
      const double z = i < 1500 ? 21 - step * i : 13.5 + step * (i - 1500);
      const auto result = tool.advance(shape, upright({20, 15, z}), Mode::cut, materials);
      ASSERT_TRUE(result.ok());
      const double force = result.value().wrench.force.z();
      largest = std::max(largest, std::abs(force - last));
      max = std::max(max, force);
      last = force;
      touched |= result.value().touching && !result.value().cutting;
      cut |= result.value().cutting;
    }
    EXPECT_TRUE(touched && cut);
    EXPECT_GT(max, 2 * wood().yield_n);
    EXPECT_LE(largest, std::max(1.01 * spring.stiffness_n_mm * step, 0.005 * max));
    EXPECT_EQ(last, 0);
  }
}

// A cut thinner than a cell also resists by its section, at any position on the lattice.
TEST(SpringTool, ThinCutsResistByTheirSection) {
  const auto check = [](double depth, double at, bool by_chip) {
    TriDexel model(make_lattice(Vec3(40, 30, 12.03 + at), 0.2, 4).value());
    model.fill_block({Vec3::Zero(), Vec3(40, 30, 12.03 + at)}, 0);
    const SeriesSpring spring{20, 0, 0.2, 0.001};
    const double z = 12.03 + at - depth;
    SpringTool tool(model, upright({-4, 15, z}), spring);
    Material hard = wood();
    hard.u = 5;
    if (by_chip) hard.k = {5, 5, 5}, hard.m = 0.3;
    double sum = 0, largest = 0;
    int count = 0;
    for (int i = 0; i < 1200; i++) {
      const auto result = tool.advance(BoxTool{Vec3(3, 10.03, 10)}, upright({-4 + 0.02 * i, 15, z}),
                                       Mode::cut, {hard});
      ASSERT_TRUE(result.ok());
      if (result.value().pose.tip.x() < 4) continue;
      const double force = -result.value().wrench.force.x();
      sum += force;
      largest = std::max(largest, force);
      count++;
    }
    const double wanted = hard.yield_n + 5 * 10.03 * std::pow(depth, 1 - hard.m);
    EXPECT_NEAR(sum / count, wanted, (by_chip ? 0.12 : 0.06) * wanted)
        << depth << " " << at << " " << by_chip;
    EXPECT_LT(largest, 1.7 * wanted) << depth << " " << at << " " << by_chip;
  };
  for (const double depth : {0.06, 0.1, 0.17, 0.3, 0.7})
    for (const double at : {0.0, 0.06, 0.13})
      for (const bool by_chip : {false, true}) check(depth, at, by_chip);
}

// A ball that turns about its own axis has the same body. So it meets the same resistance and cuts
// the same groove as one that does not turn. A trial of a turning tool consists of substeps, and
// what two of them reach counts once.
TEST(SpringTool, ATurnAboutItsAxisDoesNotChangeTheResistance) {
  std::array<double, 2> force{}, depth{};
  for (const bool turns : {false, true}) {
    TriDexel model = block(0.25);
    SeriesSpring spring{20, 0, 0.2, 0.001};
    SpringTool tool(model, upright({-6, 15, 17}), spring);
    Material hard = wood();
    hard.u = 2;
    int count = 0;
    for (int i = 0; i < 900; i++) {
      const Pose hand{Vec3(-6 + 0.05 * i, 15, 17), rotation(Vec3(0, 0, turns ? 0.02 * i : 0))};
      const auto result = tool.advance(BallTool{4}, hand, Mode::cut, {hard});
      ASSERT_TRUE(result.ok());
      const double at = result.value().pose.tip.x();
      if (at < 8 || at > 30) continue;
      force[turns] += result.value().wrench.force.norm();
      depth[turns] += 20 - result.value().pose.tip.z();
      count++;
    }
    force[turns] /= count;
    depth[turns] /= count;
  }
  EXPECT_GT(force[0], 10);
  EXPECT_NEAR(force[1], force[0], 0.02 * force[0]);
  EXPECT_NEAR(depth[1], depth[0], 0.02);
}

// The lower face of the tool is on a plane of nodes, on a boundary of cells, or between them.
TEST(SpringTool, CutsAtWholePositionsResistByTheirSection) {
  for (const double depth : {0.05, 0.09, 0.10, 0.15, 0.20, 0.25, 0.30, 0.50}) {
    TriDexel model(make_lattice(Vec3(40, 20, 6), 0.2, 2).value());
    model.fill_block({Vec3::Zero(), Vec3(40, 20, 6)}, 0);
    SpringTool tool(model, upright({-4, 10, 6 - depth}), SeriesSpring{20, 0, 0.2, 0.001});
    Material hard = wood();
    hard.u = 5;
    double sum = 0;
    int count = 0;
    for (int i = 0; i < 1200; i++) {
      const auto result = tool.advance(BoxTool{Vec3(3, 10, 10)},
                                       upright({-4 + 0.02 * i, 10, 6 - depth}), Mode::cut, {hard});
      ASSERT_TRUE(result.ok());
      if (result.value().pose.tip.x() < 4) continue;
      sum -= result.value().wrench.force.x();
      count++;
    }
    const double wanted = hard.yield_n + 5 * 10 * depth;
    ASSERT_GT(count, 500) << depth;
    EXPECT_NEAR(sum / count, wanted, 0.04 * wanted) << depth;
  }
}

// A recording holds the tool's path. Replayed in 1, 10 or 1000 ticks, the path leaves the same
// volume.
TEST(SpringTool, SplittingTheToolsPathChangesNothing) {
  double left[3];
  const int ticks[3] = {1, 10, 1000};
  for (size_t n = 0; n < 3; n++) {
    TriDexel model = block(0.25);
    DirectTool stroke(model, upright({8, 13.3, 22}));
    for (const Vec3& to : {Vec3(20.1, 15.2, 18.3), Vec3(33.7, 12.4, 17.9)}) {
      const Vec3 from = stroke.pose().tip;
      for (int i = 1; i <= ticks[n]; i++)
        ASSERT_TRUE(stroke
                        .advance(Finger{0.2, 15},
                                 from + (to - from) * (static_cast<double>(i) / ticks[n]),
                                 Vec3::Zero(), Mode::cut, {}, {wood()})
                        .ok());
    }
    left[n] = model.volume_mm3();
  }
  for (size_t n = 1; n < 3; n++) {
    std::printf("the tool's path in %d ticks: %.1g of the volume\n", ticks[n],
                left[n] / left[0] - 1);
    EXPECT_NEAR(left[n] / left[0], 1, 1e-6);
  }
}

// A tool that has cut knows that its region is clear. A deposit and a tool that turns must not use
// this: their first tick gives the same result as the first tick of a new stroke.
TEST(SpringTool, AClearStartIsOfCutsThatDoNotTurn) {
  std::vector<Material> materials{wood()};
  materials[0].u = 0.01;
  materials[0].yield_n = 0;
  double max = 0;
  for (const Tool& shape : {Tool(Finger{0.2, 15}), Tool(BallTool{3}), Tool(Bull{3, 1, 15})})
    for (const bool turns : {false, true}) {
      double added[2], distance[2];
      for (const bool fresh : {false, true}) {
        TriDexel model = block(0.25);
        SpringTool tool(model, upright({20, 15, 21}), {1.5, 0, 0.2, 0.001});
        Pose device = upright({20, 15, 21});
        for (int i = 0; i < 700; i++) {
          device.tip.z() -= 0.01;
          ASSERT_TRUE(tool.advance(shape, device, Mode::cut, materials).ok());
        }
        if (fresh) tool.begin_stroke();
        device.tip = tool.pose().tip + (turns ? Vec3(0, 0, 0.02) : Vec3(0.5, 0, 0.5));
        if (turns) device.frame = rotation(Vec3(0, 0.003, 0));
        const auto result =
            tool.advance(shape, device, turns ? Mode::touch : Mode::deposit, materials);
        ASSERT_TRUE(result.ok());
        added[fresh] = result.value().removed_mm3;
        distance[fresh] = result.value().motion.travel.norm();
      }
      EXPECT_EQ(added[0], added[1]) << turns;
      EXPECT_EQ(distance[0], distance[1]) << turns;
      max = std::min(max, added[0]);
    }
  EXPECT_LT(max, -1);
}

// The tool's recorded steps, without device and spring, leave the model bit for bit as the hand
// left it.
TEST(SpringTool, ARecordedPathLeavesTheSameBytes) {
  Random random;
  int edits = 0;
  for (int round = 0; round < 40; round++) {
    const Tool tools[] = {BallTool{3}, Finger{0.2, 15}, Flat{2, 15}, Cone{60, 3, 15},
                          Capsule{2, 9}};
    const Tool& shape = tools[round % 5];
    TriDexel live = block(0.5), again = block(0.5);
    const Pose start{{20, 15, 24}, frame_from_axis(Vec3(0.2, 0.1, 1).normalized(), 0)};
    SpringTool tool(live, start, {1.5, round % 3 == 0 ? 30.0 : 0, 0.2, 0.001});
    DirectTool stroke(again, start);
    std::vector<Material> materials{wood()};
    materials[0].yield_n = round % 2 ? 0.3 : 0;
    const Mode mode = round % 7 == 6 ? Mode::deposit : Mode::cut;
    Pose device = start;
    Vec3 velocity = Vec3(0, 0, -0.05), spin = Vec3::Zero();
    for (int i = 0; i < 400; i++) {
      velocity += 0.01 * random.in_box(-1, 1);
      if ((device.tip - Vec3(20, 15, 19)).dot(velocity) > 0)
        velocity *= 0.9, velocity -= 0.002 * (device.tip - Vec3(20, 15, 19));
      if (i % 50 == 0) spin = round % 4 == 1 ? Vec3(0.01 * random.direction()) : Vec3(Vec3::Zero());
      device.tip += velocity;
      device.frame = rotation(spin) * device.frame;
      const auto result = tool.advance(shape, device, mode, materials);
      ASSERT_TRUE(result.ok()) << result.error();
      const ToolTick& f = result.value();
      edits += f.edited;
      const auto tick = stroke.advance(shape, f.pose.tip, f.motion.turn,
                                       f.edited ? mode : Mode::off, {}, materials);
      ASSERT_TRUE(tick.ok()) << tick.error();
      ASSERT_EQ(stroke.pose().tip, f.pose.tip);
      ASSERT_EQ(stroke.pose().frame, f.pose.frame) << i << random.note();
      if (f.edited) {
        ASSERT_EQ(tick.value().removed_mm3, f.removed_mm3) << i << random.note();
      }
    }
    ASSERT_EQ(live.content_hash(), again.content_hash()) << round << random.note();
  }
  EXPECT_GT(edits, 2000);
}

// Splitting the device's path into more ticks changes the result a little, because the spring acts
// in each tick. Prints the change.
TEST(SpringTool, SplittingTheDevicesPathMattersLittle) {
  const std::vector<Material> materials{wood()};
  double removed[3];
  Vec3 tip[3];
  const int parts[3] = {1, 10, 100};
  for (size_t n = 0; n < 3; n++) {
    TriDexel model = block(0.25);
    const double before = model.volume_mm3();
    SeriesSpring spring{1.5, 0, 0.2, 0.001 / parts[n]};
    SpringTool tool(model, upright({8, 15, 22}), spring);
    const auto at = [](double t) { return Vec3(8 + 20 * t, 15, std::max(18.5, 22 - 20 * t)); };
    for (int i = 1; i <= 500 * parts[n]; i++)
      ASSERT_TRUE(
          tool.advance(BallTool{4}, upright(at(0.002 * i / parts[n])), Mode::cut, materials).ok());
    removed[n] = before - model.volume_mm3();
    tip[n] = tool.pose().tip;
  }
  for (size_t n = 1; n < 3; n++) {
    const double share = removed[n] / removed[0] - 1, moved = length(tip[n] - tip[0]);
    std::printf("the device's path in %d parts: %s of the volume, %.2g mm of the tool's place\n",
                parts[n], percent(share).c_str(), moved);
    EXPECT_LT(std::abs(share), 0.05);
    EXPECT_LT(moved, 0.05);
  }
}

TEST(SpringTool, WaitsUntilItIsOutside) {
  TriDexel model = block(0.5);
  const std::vector<Material> materials{wood()};
  SpringTool tool(model, upright({20, 15, 10}), {});
  const double before = model.volume_mm3();
  for (int i = 0; i < 300; i++) {
    const auto result =
        tool.advance(BallTool{2}, upright({20, 15, 10 + 0.05 * i}), Mode::cut, materials);
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(length(result.value().wrench.force), 0);
    const double z = 10 + 0.05 * i;
    if (std::abs(z - 20) > 0.1) {
      EXPECT_EQ(result.value().inside, z < 20) << z;
    }
  }
  EXPECT_EQ(model.volume_mm3(), before);
}

}  // namespace
}  // namespace kibori::spring_tool_tests
