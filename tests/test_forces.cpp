// SPDX-License-Identifier: MIT
// Forces against the closed forms and properties of the method (paper, sections 2-4c and 3-2).
#include <cmath>

#include <gtest/gtest.h>

#include <kibori/motion/direct_tool.h>

#include "tests/plain_material.h"
#include "tests/support.h"

namespace kibori::forces_tests {
namespace {

using test::Random;

constexpr double kPi = 3.14159265358979323846;

struct Bench {
  TriDexel model;
  std::vector<Material> materials{test::plain_material("test", 0.001, 2)};
  Bench(const Vec3& size, double pitch, double room = 0)
      : model(make_lattice(size, pitch, room).value()) {
    model.fill_block({Vec3::Zero(), size}, 0);
  }
};

const Tool kFinger = Finger{0.1, 60};

ToolTick go(DirectTool& stroke, const Tool& tool, const Vec3& to, const Bench& bench,
            ForceModel law, int dof = 5, Mode mode = Mode::cut, const Vec3& turn = Vec3::Zero()) {
  Result<ToolTick> tick = stroke.advance(tool, to, turn, mode, {law, dof}, bench.materials);
  EXPECT_TRUE(tick) << tick.error();
  return tick.value();
}

// Upright, horizontal, constant depth: dV = delta 4/3 d^1.5 / sqrt(Ks), lever 0.6 d.
TEST(Energy, UprightScrapeHasTheClosedForm) {
  const double ks = 0.1, depth = 10;  // widest radius 10 mm = 40 cells at pitch 0.25
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.6, 0.8, 0)}) {
    Bench bench(Vec3(60, 60, 20), 0.25);
    DirectTool stroke(bench.model, Pose{Vec3(15, 15, 20 - depth), Mat3::Identity()});
    // First enter the stock, then measure the steady cut.
    Vec3 at = stroke.pose().tip;
    double force = 0, moment = 0, volume = 0;
    const double step = 0.1;
    int count = 0;
    for (int i = 0; i < 220; i++) {
      at += step * direction;
      const ToolTick tick = go(stroke, kFinger, at, bench, ForceModel::energy);
      if (i < 20) continue;
      count++;
      force += -tick.wrench.force.dot(direction);
      moment += tick.wrench.moment.norm();
      volume += tick.removed_mm3;
      EXPECT_NEAR(tick.wrench.force.cross(direction).norm(), 0, 1e-9);
      EXPECT_NEAR(tick.wrench.moment.z(), 0, 1e-9);
      EXPECT_NEAR(tick.wrench.moment.dot(tick.wrench.force), 0, 1e-9);
    }
    const double expected = step * (4.0 / 3) * std::pow(depth, 1.5) / std::sqrt(ks);
    EXPECT_NEAR(volume / count, expected, 0.01 * expected);
    EXPECT_NEAR(force / count, 2.0 * expected / step, 0.01 * 2 * expected / step);
    EXPECT_NEAR(moment / count, 0.6 * depth * 2 * expected / step,
                0.01 * 0.6 * depth * 2 * expected / step);
  }
}

// Plunge along the axis: dV = delta pi d / Ks, no moment.
TEST(Energy, PlungeHasTheClosedFormAndNoMoment) {
  Bench bench(Vec3(60, 60, 20), 0.25);
  DirectTool stroke(bench.model, Pose{Vec3(30.1, 29.8, 21), Mat3::Identity()});
  const double step = 0.05;
  double worst = 0;
  for (int i = 1; i <= 240; i++) {
    const double z = 21 - step * i;
    const ToolTick tick = go(stroke, kFinger, Vec3(30.1, 29.8, z), bench, ForceModel::energy);
    const double deep = 20 - z;
    if (deep > 1.5 * step) {
      // The force is late by half a cell of path.
      const double expected = step * kPi * (deep - step / 2 - 0.125) / 0.1;
      worst = std::max(worst, std::abs(tick.wrench.force.z() / (2.0 * expected / step) - 1) *
                                  (deep > 10 ? 1 : 0));
      EXPECT_GT(tick.wrench.force.z(), 0);
    } else if (deep <= 0) {
      EXPECT_EQ(tick.wrench.force.norm(), 0);
    }
    // The finger is not on the lattice's symmetry axis. So the lever is zero only up to the
    // rounding of the nodes.
    EXPECT_NEAR(tick.wrench.moment.norm(), 0, 1e-6 * (1 + tick.wrench.force.norm()));
  }
  EXPECT_LT(worst, 0.01);
}

// When the finger has passed both faces of a slab of thickness t, the force is constant:
// dV = delta pi t / Ks.
TEST(Energy, PlungeThroughASlabIsAPlateau) {
  Bench bench(Vec3(60, 60, 4), 0.25, 0);
  DirectTool stroke(bench.model, Pose{Vec3(30.1, 29.8, 4), Mat3::Identity()});
  const double step = 0.05;
  for (int i = 1; i <= 240; i++) {
    const double z = 4 - step * i;
    const ToolTick tick = go(stroke, kFinger, Vec3(30.1, 29.8, z), bench, ForceModel::energy);
    if (z > -3 || z < -7) continue;
    EXPECT_NEAR(tick.wrench.force.z(), 2.0 * kPi * 4 / 0.1, 0.01 * 2.0 * kPi * 4 / 0.1);
    EXPECT_NEAR(tick.removed_mm3, step * kPi * 4 / 0.1, 0.01 * step * kPi * 4 / 0.1);
  }
}

// A flat bottom moves down and sideways. In every tick, the force must be u times the area that the
// bottom and the front sweep. This is difficult, because the bottom crosses a row of x rays only in
// some ticks, and then the whole row at once.
TEST(Energy, AFlatBottomThatSinksResistsEvenly) {
  Random random;
  SCOPED_TRACE(random.note());
  for (const Tool& tool : {Tool(Flat{5, 40}), Tool(BoxTool{Vec3(8, 10, 40)})}) {
    for (const double sink : {0.02, 0.2, 0.6}) {
      for (const double step : {0.02, 0.06}) {
        Bench bench(Vec3(60, 40, 20), 0.25);
        const Vec3 direction(std::cos(sink), 0, -std::sin(sink));
        const double off = random.uniform(0, 0.25);
        DirectTool stroke(bench.model, Pose{Vec3(20 + off, 20 + off, 15 + off), Mat3::Identity()});
        const bool round = std::holds_alternative<Flat>(tool);
        const double bottom = round ? kPi * 25 : 80, front_x = round ? kPi * 5 / 4 : 4;
        for (int i = 1; i <= 160; i++) {
          const Vec3 to = stroke.pose().tip + step * direction;
          const ToolTick tick = go(stroke, tool, to, bench, ForceModel::energy, 6);
          if (i <= 20) continue;  // the front of the cut is not complete yet
          const double deep = 20 - to.z() - 0.5 * step * direction.z();
          const double front = 10 * deep * direction.x(),
                       force = 2 * (front - bottom * direction.z());
          const double moment = 2 * front * (0.5 * deep * direction.x() - front_x * direction.z());
          // The front is as many rays high and wide as rays meet it: an error of half a cell.
          const double rays = 0.125 * (1 / deep + 1.0 / 10);
          EXPECT_NEAR(-tick.wrench.force.dot(direction), force, (rays + 0.02) * force)
              << sink << " " << i;
          EXPECT_NEAR(-tick.wrench.moment.y(), moment, (2 * rays + 0.02) * moment)
              << sink << " " << i;
          EXPECT_LT(tick.wrench.force.cross(direction).norm(), 1e-9 * force);
        }
      }
    }
  }
}

// Flat tools at any angle and along the lattice: their work over a path is u times what they
// remove.
TEST(Energy, FlatToolsDoTheWorkOfWhatTheyRemove) {
  Random random;
  SCOPED_TRACE(random.note());
  const Tool tools[] = {Flat{4, 14}, Bull{4, 1.5, 14}, BoxTool{Vec3(5, 7, 9)}, TSlot{}};
  constexpr int kTrials = 24;
  for (int trial = 0; trial < kTrials; trial++) {
    const Tool& tool = tools[trial % 4];
    Bench bench(Vec3(40, 40, 30), 0.25);
    const bool along = random.integer(0, 1);
    const Pose start{
        Vec3(20, 20, 15) + random.in_box(-3, 3),
        frame_from_axis(along ? Vec3(Vec3::Unit(random.integer(0, 2))) : random.direction())};
    const Vec3 direction = random.direction();
    const double step = random.uniform(0.02, 0.2);
    DirectTool stroke(bench.model, start);
    double work = 0, volume = 0, first = 0;
    for (int i = 1; i * step < 8; i++) {
      const ToolTick tick =
          go(stroke, tool, start.tip + i * step * direction, bench, ForceModel::energy);
      EXPECT_LE(tick.wrench.force.dot(direction), 0);
      if (i == 1)
        // most of what it removed is the volume that it occupies at the start
        first = stroke.unpaid_cells();
      else
        volume += tick.removed_mm3;
      work -= tick.wrench.force.dot(tick.motion.travel);
    }
    const double cell = 0.25 * 0.25 * 0.25, paid = volume + cell * (first - stroke.unpaid_cells());
    EXPECT_NEAR(work, 2 * paid, 0.02 * 2 * volume + 1e-9) << trial << " " << shape_of(tool);
  }
}

// One motion in 1, 10 or 1000 ticks removes the same and does the same work, to 0.1 per mille.
TEST(Energy, SplittingAMoveChangesNothing) {
  for (const Vec3& motion : {Vec3(30, 0, -3), Vec3(20, 18, -4), Vec3(7, -13, -2)}) {
    double first_volume = 0, first_work = 0;
    for (const int ticks : {1, 10, 1000}) {
      Bench bench(Vec3(60, 60, 20), 0.5);
      const Vec3 start(15, 30, 14);
      DirectTool stroke(bench.model, Pose{start, frame_from_axis(Vec3(0.2, -0.1, 1))});
      double volume = 0, work = 0;
      for (int i = 1; i <= ticks; i++) {
        const Vec3 to = start + motion * (static_cast<double>(i) / ticks);
        const ToolTick tick = go(stroke, kFinger, to, bench, ForceModel::energy);
        volume += tick.removed_mm3;
        work += -tick.wrench.force.dot(tick.motion.travel);
      }
      work += 2.0 * 0.125 * stroke.unpaid_cells();
      if (ticks == 1) {
        first_volume = volume;
        first_work = work;
      }
      EXPECT_NEAR(volume, first_volume, 1e-4 * first_volume) << ticks;
      EXPECT_NEAR(work, first_work, 1e-4 * first_work) << ticks;
    }
  }
}

// F.p + M.theta = -u dV over a stroke, also while the tool turns.
TEST(Energy, WorkEqualsVolumeWhileTurning) {
  Random random;
  for (int trial = 0; trial < 20; trial++) {
    Bench bench(Vec3(40, 40, 20), 0.5);
    DirectTool stroke(bench.model,
                      Pose{Vec3(20, 20, 17), frame_from_axis(random.direction() + Vec3(0, 0, 2))});
    const Vec3 direction = 0.1 * random.direction(), turn = 0.01 * random.direction();
    double work = 0, volume = 0, first = 0;
    for (int i = 0; i < 60; i++) {
      const ToolTick tick = go(stroke, kFinger, stroke.pose().tip + direction, bench,
                               ForceModel::energy, 6, Mode::cut, turn);
      const double done = tick.wrench.force.dot(tick.motion.travel) + tick.wrench.moment.dot(turn);
      ASSERT_LE(done, 1e-9);
      if (i == 0) {
        // most of what it removed is the volume that it occupies at the start
        first = stroke.unpaid_cells();
      } else {
        work -= done;
        volume += tick.removed_mm3;
      }
    }
    const double paid = volume + 0.125 * (first - stroke.unpaid_cells());
    ASSERT_NEAR(work, 2 * paid, 0.02 * 2 * volume + 1e-9) << random.note();
  }
}

// A turn about the tip without travel also resists, and stays finite.
TEST(Energy, TurningOnTheSpotGivesAMomentAndStaysFinite) {
  Bench bench(Vec3(40, 40, 20), 0.5);
  DirectTool stroke(bench.model, Pose{Vec3(20, 20, 8), Mat3::Identity()});
  go(stroke, kFinger, Vec3(20, 20, 8), bench, ForceModel::energy);
  for (int i = 0; i < 50; i++) {
    const ToolTick tick = go(stroke, kFinger, Vec3(20, 20, 8), bench, ForceModel::energy, 6,
                             Mode::cut, Vec3(0, 0.01, 0));
    EXPECT_TRUE(tick.wrench.moment.allFinite());
    EXPECT_LT(tick.wrench.moment.y(), 0);
    EXPECT_EQ(go(stroke, kFinger, Vec3(20, 20, 8), bench, ForceModel::paper, 6, Mode::off)
                  .wrench.force.norm(),
              0);
  }
}

// |F| = Kf K, antiparallel to p, and M = -Kf (sum z) e_z x p. The oracle counts the nodes that
// vanish from a bitmap, which is carved by the definition of the finger.
TEST(Paper, CountsExactlyTheNodesThatVanish) {
  Random random;
  const double h = 0.5;
  for (int trial = 0; trial < 4; trial++) {
    const Vec3 size(14, 12, 10);
    Bench bench(size, h);
    const Index3 n = bench.model.lattice().nodes;
    std::vector<bool> there(static_cast<size_t>(n.prod()), true);
    const Tool tool = Finger{random.uniform(0.1, 0.6), 30};
    const Finger& finger = std::get<Finger>(tool);
    const Mat3 frame = frame_from_axis(random.direction() + Vec3(0, 0, 1.5));
    Vec3 at = Vec3(7, 6, 13) + random.in_box(-3, 3);
    DirectTool stroke(bench.model, Pose{at, frame});
    int64_t total = 0, borderline = 0;
    for (int i = 0; i < 60; i++) {
      const Vec3 p = 0.3 * (random.direction() - Vec3(0, 0, i < 30 ? 0.7 : 0.0));
      const Vec3 to = at + p;
      const ToolTick tick = go(stroke, tool, to, bench, ForceModel::paper);
      int64_t count = 0;
      Vec3 sum = Vec3::Zero();
      for (int k = 0; k < n.z(); k++)
        for (int j = 0; j < n.y(); j++)
          for (int m = 0; m < n.x(); m++) {
            const auto index = static_cast<size_t>((k * n.y() + j) * n.x() + m);
            if (!there[index]) continue;
            const Vec3 node =
                bench.model.lattice().to_mm(LatticePoint{Vec3(m + 0.5, j + 0.5, k + 0.5)});
            // The largest f over the motion: f is concave in s.
            const Vec3 x = frame.transpose() * (node - at), v = frame.transpose() * p;
            const auto f = [&](double s) {
              const Vec3 y = x - s * v;
              return std::min(y.z() - finger.ks * (y.x() * y.x() + y.y() * y.y()),
                              finger.length - y.z());
            };
            double low = 0, high = 1;
            for (int it = 0; it < 45; it++) {
              const double a = low + (high - low) / 3, b = high - (high - low) / 3;
              (f(a) < f(b) ? low : high) = f(a) < f(b) ? a : b;
            }
            const double best = std::max({f(low), f(0), f(1)});
            if (std::abs(best) < 1e-5) borderline++;
            if (best <= 0) continue;
            there[index] = false;
            count++;
            sum += node - to;
          }
      ASSERT_NEAR(static_cast<double>(tick.points), static_cast<double>(count),
                  static_cast<double>(borderline))
          << random.note();
      ASSERT_NEAR(tick.wrench.force.norm(), 0.001 * static_cast<double>(tick.points), 1e-12);
      ASSERT_NEAR(tick.wrench.force.cross(p).norm(), 0, 1e-12);
      if (borderline == 0) {
        const Vec3 axis = frame.col(2);
        const Vec3 moment = -0.001 * sum.dot(axis) * axis.cross(p.normalized());
        ASSERT_NEAR((tick.wrench.moment - moment).norm(), 0, 1e-9) << random.note();
      }
      ASSERT_NEAR(tick.wrench.moment.dot(frame.col(2)), 0, 1e-9);
      total += tick.points;
      at = to;
    }
    int64_t missing = 0;
    for (bool b : there) missing += b ? 0 : 1;
    EXPECT_NEAR(static_cast<double>(total), static_cast<double>(missing),
                static_cast<double>(borderline));
  }
}

TEST(Paper, RepeatingAPathOrRetractingRemovesNothing) {
  Bench bench(Vec3(40, 40, 20), 0.25);
  const Vec3 a(-12, 20.3, 16), b(52, 19.7, 13.5);
  DirectTool stroke(bench.model, Pose{a, Mat3::Identity()});
  for (int i = 1; i <= 40; i++)
    go(stroke, kFinger, a + (b - a) * (i / 40.0), bench, ForceModel::paper);
  int64_t again = 0;
  double again_mm3 = 0;
  for (int i = 39; i >= 0; i--) {
    const ToolTick tick = go(stroke, kFinger, a + (b - a) * (i / 40.0), bench, ForceModel::paper);
    again += tick.points;
    again_mm3 += tick.removed_mm3;
  }
  EXPECT_EQ(again, 0);
  EXPECT_NEAR(again_mm3, 0, 1e-3);
  EXPECT_EQ(go(stroke, kFinger, a, bench, ForceModel::paper).wrench.force.norm(), 0) << "p = 0";
}

// Touch computes the force of a cut, tick by tick, and changes nothing.
TEST(Touch, ForeseesTheCut) {
  for (const ForceModel law : {ForceModel::paper, ForceModel::energy}) {
    Bench touched(Vec3(40, 40, 20), 0.25), cut_bench(Vec3(40, 40, 20), 0.25);
    const Vec3 a(20, 20, 22), b(20, 20, 12);
    DirectTool probe(touched.model, Pose{a, Mat3::Identity()}),
        carve(cut_bench.model, Pose{a, Mat3::Identity()});
    const uint64_t before = touched.model.content_hash();
    for (int i = 1; i <= 50; i++) {
      const Vec3 to = a + (b - a) * (i / 50.0);
      const ToolTick t = go(probe, kFinger, to, touched, law, 6, Mode::touch);
      const ToolTick c = go(carve, kFinger, to, cut_bench, law, 6, Mode::cut);
      // A cut rounds its result to float32. The touch compares with the exact start pose.
      EXPECT_NEAR((t.wrench.force - c.wrench.force).norm(), 0, 1e-3 * (1 + c.wrench.force.norm()))
          << i;
      EXPECT_NEAR(static_cast<double>(t.points), static_cast<double>(c.points), 2) << i;
    }
    EXPECT_EQ(touched.model.content_hash(), before);
  }
}

TEST(Touch, OfAMeshToolForeseesTheCutToo) {
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = {{-3, -3, 0}, {3, -3, 0}, {0, 4, 0}, {0, 0, 8}};
  mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const Tool tool = MeshTool{mesh};
  Bench touched(Vec3(30, 30, 10), 0.5), cut_bench(Vec3(30, 30, 10), 0.5);
  const Vec3 a(15, 15, 11), b(15, 15, 5);
  DirectTool probe(touched.model, Pose{a, Mat3::Identity()}),
      carve(cut_bench.model, Pose{a, Mat3::Identity()});
  for (int i = 1; i <= 20; i++) {
    const Vec3 to = a + (b - a) * (i / 20.0);
    const ToolTick t = go(probe, tool, to, touched, ForceModel::paper, 5, Mode::touch);
    EXPECT_NEAR(static_cast<double>(t.points),
                static_cast<double>(go(carve, tool, to, cut_bench, ForceModel::paper).points), 2)
        << i;
  }
}

TEST(Deposit, ResistsByTheSameLawAndCanBeCutAwayAgain) {
  Bench bench(Vec3(40, 40, 20), 0.25, 10);
  const double volume = bench.model.volume_mm3();
  DirectTool stroke(bench.model, Pose{Vec3(10, 20, 19), Mat3::Identity()});
  const Tool ball = BallTool{3};
  double added = 0;
  for (int i = 1; i <= 40; i++) {
    const ToolTick tick =
        go(stroke, ball, Vec3(10 + 0.5 * i, 20, 19), bench, ForceModel::energy, 5, Mode::deposit);
    if (i > 1) {
      EXPECT_LT(tick.removed_mm3, 0);
      EXPECT_NEAR(-tick.wrench.force.x() * 0.5 / 2.0, -tick.removed_mm3, 0.05 * -tick.removed_mm3);
    }
    EXPECT_FALSE(tick.clipped);
    added -= tick.removed_mm3;
  }
  EXPECT_NEAR(bench.model.volume_mm3(), volume + added, 1e-6 * volume);
}

// At the start of a stroke, the tool cuts or deposits the volume that it occupies. This volume has
// no path and causes no force. The force is that of the path: u times the ball's cross-section.
TEST(Energy, OnlyThePathResistsWhereAStrokeBegins) {
  const Tool ball = BallTool{3};
  for (const Mode mode : {Mode::cut, Mode::deposit})
    for (const Vec3& turn : {Vec3(0, 0, 0), Vec3(0, 0, 1e-3)}) {
      Bench bench(Vec3(20, 20, 20), 0.25, 10);
      const double z = mode == Mode::cut ? 7 : 22;
      DirectTool stroke(bench.model, Pose{Vec3(10, 10, z), Mat3::Identity()});
      const ToolTick tick =
          go(stroke, ball, Vec3(10.1, 10, z), bench, ForceModel::energy, 5, mode, turn);
      const double expected = 2.0 * kPi * 9, volume = 4.0 / 3 * kPi * 27 + 0.1 * kPi * 9;
      EXPECT_NEAR(std::abs(tick.removed_mm3), volume, 0.01 * volume);
      // A path of 0.4 cells into a mean over one cell: 0.2 of it.
      EXPECT_NEAR(-tick.wrench.force.x(), 0.2 * expected, 0.05 * expected);
      // After a cell it is complete.
      for (int i = 2; i <= 4; i++)
        EXPECT_GT(
            go(stroke, ball, Vec3(10 + 0.1 * i, 10, z), bench, ForceModel::energy, 5, mode, turn)
                .wrench.force.norm(),
            0);
      EXPECT_NEAR(-go(stroke, ball, Vec3(10.5, 10, z), bench, ForceModel::energy, 5, mode, turn)
                       .wrench.force.x(),
                  expected, 0.05 * expected);
    }
}

// Each material resists by its own constants, and the parts add up.
TEST(Materials, ResistEachByItsOwnConstants) {
  TriDexel model(make_lattice(Vec3(20, 20, 20), 0.25, 0).value());
  model.fill_block({Vec3(0, 0, 0), Vec3(20, 20, 10)}, 0);
  const std::vector<Material> materials{test::plain_material("soft", 0.001, 1),
                                        test::plain_material("hard", 0.01, 8)};
  Removed removed;
  deposit(model,
          SweptTool(BoxTool{Vec3(20, 20, 10)}, Pose{Vec3(10, 10, 10), Mat3::Identity()},
                    Vec3::Zero(), model.lattice()),
          1, {}, removed);
  EXPECT_NEAR(model.volume_mm3(), 8000, 1e-6);
  // A flat cutter through both, half in each: the force is the area times the mean of the two.
  DirectTool stroke(model, Pose{Vec3(-6, 10, 7), Mat3::Identity()});
  const Tool flat = Flat{4, 6};
  double force = 0;
  for (int i = 1; i <= 200; i++) {
    const Result<ToolTick> tick = stroke.advance(flat, Vec3(-6 + 0.1 * i, 10, 7), Vec3::Zero(),
                                                 Mode::cut, {ForceModel::energy, 5}, materials);
    if (i > 150) force -= tick.value().wrench.force.x() / 50;
  }
  EXPECT_NEAR(force, 8 * 6 * 0.5 * (1 + 8), 0.02 * 8 * 6 * 4.5);
}

TEST(Touch, OfATurnInSeveralPiecesIsThatOfTheCut) {
  Bench touched(Vec3(20, 20, 10), 0.25), cut_bench(Vec3(20, 20, 10), 0.25);
  const Tool tool = BoxTool{Vec3(1, 9, 9)};
  const Pose start{Vec3(10, 10, 3), Mat3::Identity()};
  DirectTool probe(touched.model, start), carve(cut_bench.model, start);
  // The start pose is empty, as the touch assumes.
  go(carve, tool, start.tip, cut_bench, ForceModel::paper);
  const uint64_t before = touched.model.content_hash();
  const Vec3 turn(0, 0, 1.5);
  const ToolTick t = go(probe, tool, start.tip, touched, ForceModel::paper, 5, Mode::touch, turn);
  const ToolTick c = go(carve, tool, start.tip, cut_bench, ForceModel::paper, 5, Mode::cut, turn);
  EXPECT_GT(c.points, 1000);
  EXPECT_EQ(t.points, c.points);
  EXPECT_EQ(touched.model.content_hash(), before);
}

// Only a cut by the same ball makes the start pose clear. Here another tool cuts between two cuts
// of the ball, so the second cut of the ball must remove all material in its way.
TEST(DirectTool, AnotherToolInBetweenIsNotForgotten) {
  Bench bench(Vec3(20, 20, 10), 0.25), plain(Vec3(20, 20, 10), 0.25);
  DirectTool stroke(bench.model, Pose{Vec3(10, 10, 6), Mat3::Identity()});
  const Tool ball = BallTool{3}, flat = Flat{1, 30};
  double from = 6;
  for (const auto& [tool, to] :
       {std::pair{ball, 5.0}, std::pair{flat, 2.0}, std::pair{ball, 1.9}}) {
    go(stroke, tool, Vec3(10, 10, to), bench, ForceModel::energy);
    DirectTool fresh(plain.model, Pose{Vec3(10, 10, from), Mat3::Identity()});
    go(fresh, tool, Vec3(10, 10, to), plain, ForceModel::energy);
    from = to;
  }
  EXPECT_NEAR(bench.model.volume_mm3(), plain.model.volume_mm3(), 1e-3);
}

// A tick may be long. A motion of 200 m past a block of 20 mm removes the same as a short scrape.
TEST(DirectTool, ALongTickIsSweptInPieces) {
  double expected = 0;
  for (const double half : {100.0, 3000.0, 100000.0}) {
    Bench bench(Vec3(20, 20, 10), 0.25);
    DirectTool stroke(bench.model, Pose{Vec3(10 - half, 10, 8), Mat3::Identity()});
    const ToolTick tick = go(stroke, kFinger, Vec3(10 + half, 10, 8), bench, ForceModel::energy);
    if (expected == 0) expected = tick.removed_mm3;
    EXPECT_NEAR(tick.removed_mm3, expected, 1e-3 * expected) << half;
    EXPECT_NEAR(-tick.wrench.force.x() * half, expected, 0.01 * expected) << half;
  }
}

TEST(DirectTool, RefusesATickItCannotSplit) {
  Bench bench(Vec3(10, 10, 10), 1);
  DirectTool stroke(bench.model, Pose{});
  const auto tick =
      stroke.advance(BallTool{1}, Vec3(1e20, 0, 0), Vec3::Zero(), Mode::cut, {}, bench.materials);
  ASSERT_FALSE(tick);
  EXPECT_NE(tick.error().find("move slower"), std::string::npos);
  for (const Mode mode : {Mode::cut, Mode::off})
    for (const double turn : {1e3, 1e300, std::nan("")})
      EXPECT_FALSE(
          stroke.advance(BallTool{1}, Vec3(1, 0, 0), Vec3(0, turn, 0), mode, {}, bench.materials)
              .ok());
  EXPECT_FALSE(stroke
                   .advance(BallTool{1}, Vec3(std::nan(""), 0, 0), Vec3::Zero(), Mode::off, {},
                            bench.materials)
                   .ok());
  EXPECT_TRUE(
      stroke.advance(HalfSpace{}, Vec3(0, 0, 5), Vec3(0, 0.1, 0), Mode::cut, {}, bench.materials))
      << "a half-space may turn";
}

}  // namespace
}  // namespace kibori::forces_tests
