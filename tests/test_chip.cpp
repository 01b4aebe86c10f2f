// SPDX-License-Identifier: MIT
// The shape of chips and their law of forces (haptics/chip.h). The oracles are closed forms and
// numerical integrals, at random positions on the lattice.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/edit/grain.h>
#include <kibori/motion/direct_tool.h>

#include "tests/support.h"

namespace kibori::chip_tests {
namespace {

using test::Random;

constexpr double kPi = std::numbers::pi;

Material of_law(std::array<double, 3> k, double m) {
  Material material;
  material.k = k;
  material.m = m;
  return material;
}

// Wood with a given fibre direction and without rings.
struct Bench {
  TriDexel model;
  std::vector<Material> materials;
  Log log;
  Grain grain;

  // The part above `split` has the second material.
  Bench(const Vec3& size, double pitch, std::vector<Material> of, const Vec3& fibre = Vec3::UnitX(),
        double split = 0)
      : model(make_lattice(size, pitch, 2 * pitch).value()),
        materials(std::move(of)),
        log{Vec3::Zero(), fibre, 2},
        grain(log, model.lattice(), materials) {
    if (!(split > 0)) split = size.z();
    model.fill_block({Vec3::Zero(), Vec3(size.x(), size.y(), split)}, 0);
    if (!(split < size.z())) return;
    const double high = size.z() - split;
    const Pose at{Vec3(0.5 * size.x(), 0.5 * size.y(), split), Mat3::Identity()};
    Removed added;
    const SweptTool top(BoxTool{Vec3(size.x(), size.y(), high)}, at, Vec3::Zero(), model.lattice());
    deposit(model, top.solid(), 1, {}, added);
  }
};

ToolTick go(DirectTool& stroke, const Bench& bench, const Tool& tool, const Vec3& to,
            double thrust = 0, const Vec3& turn = Vec3::Zero()) {
  ForceLaw law{ForceModel::energy, 6};
  law.thrust = thrust;
  const Result<ToolTick> tick = stroke.advance(tool, to, turn, Mode::cut, law, bench.materials);
  EXPECT_TRUE(tick) << tick.error();
  return tick.value();
}

// Mean and standard deviation.
struct Figures {
  double sum = 0, squares = 0;
  int count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    count++;
  }
  double mean() const { return sum / count; }
  double deviation() const { return std::sqrt(std::max(0.0, squares / count - mean() * mean())); }
};

struct Shapes {
  Figures section, width, thickness, force;
};

// A steady cut along `direction` (unit, horizontal). The tool's tip is `depth` below the top of a
// block.
Shapes steady_cut(const Tool& tool, double depth, double pitch, const Vec3& direction, double roll,
                  Random& random, double step_cells = 0.15) {
  const Vec3 size = Vec3(24, 24, 6) + random.in_box(0, pitch);
  Bench bench(size, pitch, {of_law({10, 10, 10}, 0.5)});
  const Vec3 middle(0.5 * size.x(), 0.5 * size.y(), size.z() - depth);
  const Vec3 start =
      middle + Vec3(direction.cross(Vec3::UnitZ()) * random.uniform(0, pitch)) - 3 * direction;
  DirectTool stroke(bench.model, Pose{start, frame_from_axis(Vec3::UnitZ(), roll)});
  stroke.set_grain(&bench.grain);
  Shapes shapes;
  const double step = step_cells * pitch;
  double path = 0;
  // Skips the volume that the tool occupies at its start.
  while (path < 5) {
    path += step;
    const ToolTick tick = go(stroke, bench, tool, start + path * direction);
    if (path < 2) continue;
    shapes.section.add(stroke.chip().section_mm2);
    shapes.width.add(stroke.chip().width_mm);
    shapes.thickness.add(stroke.chip().thickness_mm);
    shapes.force.add(-tick.wrench.force.dot(direction));
  }
  return shapes;
}

TEST(Chip, OfAChiselIsAsWideAndThickAsItsCut) {
  Random random;
  SCOPED_TRACE(random.note());
  const double pitch = 0.2, width = 5;
  for (const double cells : {0.45, 1.5, 5.0})
    for (int i = 0; i < 12; i++) {
      const double depth = cells * pitch;
      // Along an axis, near it, and oblique.
      const double turn = i % 3 == 0 ? 0 : i % 3 == 1 ? 0.02 : random.uniform(0, 2 * kPi);
      const Vec3 direction(std::cos(turn), std::sin(turn), 0);
      const Shapes s =
          steady_cut(BoxTool{Vec3(2, width, 8)}, depth, pitch, direction, turn, random);
      // A bound for one position on the lattice. It is wide for thin cuts, because their sides are
      // known only to a fraction of the distance between rays.
      EXPECT_NEAR(s.width.mean(), width, (cells < 1 ? 0.04 : 0.015) * width)
          << cells << " " << turn;
      EXPECT_NEAR(s.thickness.mean(), depth, (cells < 1 ? 0.03 : 0.015) * depth)
          << cells << " " << turn;
      const double force = 10 * width * std::sqrt(depth);
      EXPECT_NEAR(s.force.mean(), force, 0.02 * force) << cells << " " << turn;
      EXPECT_LT(s.force.deviation(), (cells < 1 ? 0.25 : 0.05) * force) << cells << " " << turn;
    }
}

// The chip of a ball is the segment of a circle. Its width is that of the rectangle with the same
// variance.
TEST(Chip, OfABallIsTheSegmentOfItsGroove) {
  Random random;
  SCOPED_TRACE(random.note());
  const double pitch = 0.25, radius = 2;
  for (const double cells : {0.6, 1.5, 4.0}) {
    const double depth = cells * pitch;
    double area = 0, variance = 0;
    for (double y = -radius; y < radius; y += 1e-4) {
      const double high = std::sqrt(radius * radius - y * y) - (radius - depth);
      if (high <= 0) continue;
      area += high * 1e-4;
      variance += high * 1e-4 * y * y;
    }
    const double width = std::sqrt(12 * variance / area);
    for (int i = 0; i < 6; i++) {
      const double turn = i == 0 ? 0 : random.uniform(0, 2 * kPi);
      const Shapes s = steady_cut(BallTool{radius}, depth, pitch,
                                  Vec3(std::cos(turn), std::sin(turn), 0), 0, random);
      // Bounds for one position on the lattice. ForcePoses.ChipsOfTheMethod checks the means over
      // many positions.
      EXPECT_NEAR(s.section.mean(), area, (cells < 1 ? 0.08 : 0.03) * area) << cells << " " << turn;
      EXPECT_NEAR(s.width.mean(), width, (cells < 1 ? 0.12 : 0.06) * width) << cells << " " << turn;
      EXPECT_LT(s.section.deviation(), (cells < 1 ? 0.15 : 0.03) * area) << cells << " " << turn;
    }
  }
}

// F = w tau(t) (kA (f.n)^2 + kB (f.p)^2 + kC (f.e)^2) for a flat chip of any direction.
TEST(Chip, ForcesFollowThreeDirectionsOfTheFibres) {
  Random random;
  SCOPED_TRACE(random.note());
  const double pitch = 0.2, width = 8, depth = 0.6;
  const std::array<double, 3> k{30, 10, 7};
  for (int i = 0; i < 12; i++) {
    const Vec3 fibre = i < 3 ? Vec3(Vec3::Unit(i)) : random.direction();
    const double turn = random.uniform(0, 2 * kPi);
    const Vec3 p(std::cos(turn), std::sin(turn), 0), n = Vec3::UnitZ(), e = n.cross(p);
    Bench bench(Vec3(24, 24, 6), pitch, {of_law(k, 0.5)}, fibre);
    const Vec3 start = Vec3(12, 12, 6 - depth) - 2 * p;
    DirectTool stroke(bench.model, Pose{start, frame_from_axis(n, turn)});
    stroke.set_grain(&bench.grain);
    Figures force;
    for (int j = 1; j <= 120; j++) {
      const ToolTick tick = go(stroke, bench, BoxTool{Vec3(2, width, 8)}, start + 0.03 * j * p);
      if (j > 60) force.add(-tick.wrench.force.dot(p));
    }
    const double by = k[0] * std::pow(fibre.dot(n), 2) + k[1] * std::pow(fibre.dot(p), 2) +
                      k[2] * std::pow(fibre.dot(e), 2);
    // The chip is not completely flat, so a small part of the force is that of end grain.
    const double flat = std::pow(depth / width, 2) * (k[0] - k[2]);
    const double wanted = width * std::sqrt(depth) * by;
    EXPECT_NEAR(force.mean(), wanted, 0.02 * wanted + width * std::sqrt(depth) * flat)
        << fibre.transpose();
  }
}

// Up to 1 mm the factor is a power of the thickness. Above 1 mm it continues as its tangent.
TEST(Chip, TheFactorOfThicknessIsSmooth) {
  for (const double m : {0.0, 0.3, 0.5, 1.0}) {
    EXPECT_NEAR(thickness_factor(0.25, m), std::pow(0.25, 1 - m), 1e-12);
    EXPECT_NEAR(thickness_factor(3, m), 1 + 2 * (1 - m), 1e-12);
    EXPECT_NEAR(thickness_factor(1 - 1e-9, m), thickness_factor(1 + 1e-9, m), 1e-8);
  }
}

// Two layers of the same wood, entered as two materials, resist like one layer.
TEST(Chip, TwoLayersOfOneWoodResistAsOne) {
  const double pitch = 0.2;
  double forces[2];
  for (const int layers : {1, 2}) {
    const Material wood = of_law({30, 10, 7}, 0.5);
    Bench bench(Vec3(24, 24, 6), pitch, {wood, wood}, Vec3::UnitX(), layers == 2 ? 5.63 : 0);
    DirectTool stroke(bench.model, Pose{Vec3(9, 12, 5), Mat3::Identity()});
    stroke.set_grain(&bench.grain);
    Figures force;
    for (int j = 1; j <= 120; j++) {
      const ToolTick tick = go(stroke, bench, BoxTool{Vec3(2, 6, 8)}, Vec3(9 + 0.03 * j, 12, 5));
      if (j > 60) force.add(tick.wrench.force.norm());
    }
    forces[layers - 1] = force.mean();
  }
  EXPECT_NEAR(forces[1], forces[0], 0.02 * forces[0]);
}

// A chisel over a groove cuts two strips. Each resists as it would alone.
TEST(Chip, TwoStripsResistAsTwo) {
  for (const double turn : {0.0, 0.3, kPi / 4, kPi / 2}) {
    const Vec3 p(std::cos(turn), std::sin(turn), 0), e(-p.y(), p.x(), 0);
    Bench bench(Vec3(30, 30, 6), 0.25, {of_law({10, 10, 10}, 0.5)});
    const Vec3 middle(15, 15, 5.4);
    // Leaves two rails, 2 mm wide and 10 mm apart.
    for (const double off : {-12.0, 0.0, 12.0}) {
      DirectTool clear(bench.model,
                       Pose{middle + off * e - 30 * p, frame_from_axis(Vec3::UnitZ(), turn)});
      go(clear, bench, BoxTool{Vec3(2, 10, 8)}, middle + off * e + 30 * p);
    }
    DirectTool stroke(bench.model, Pose{middle - 3 * p, frame_from_axis(Vec3::UnitZ(), turn)});
    stroke.set_grain(&bench.grain);
    Figures force;
    for (int j = 1; j <= 120; j++) {
      const ToolTick tick = go(stroke, bench, BoxTool{Vec3(2, 20, 8)}, middle + (0.04 * j - 3) * p);
      if (j > 60) force.add(-tick.wrench.force.dot(p));
    }
    const double wanted = 10 * 4 * std::sqrt(0.6);
    EXPECT_NEAR(force.mean(), wanted, 0.12 * wanted) << turn;
  }
}

// The section of a plunge is round, so directions A and C have the same weight.
TEST(Chip, OfAPlungeIsRound) {
  const double radius = 3;
  for (const Vec3& fibre : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
    Bench bench(Vec3(16, 16, 8), 0.25, {of_law({30, 10, 7}, 0.5)}, fibre);
    DirectTool stroke(bench.model, Pose{Vec3(8.1, 7.9, 8.2), Mat3::Identity()});
    stroke.set_grain(&bench.grain);
    Figures force;
    for (int j = 1; j <= 100; j++) {
      const ToolTick tick = go(stroke, bench, Flat{radius, 20}, Vec3(8.1, 7.9, 8.2 - 0.05 * j));
      if (j > 40) force.add(tick.wrench.force.z());
    }
    EXPECT_NEAR(stroke.chip().width_mm, std::sqrt(3) * radius, 0.02 * radius);
    const double k = fibre.z() > 0.5 ? 10 : 18.5;
    const double wanted =
        k * std::sqrt(3) * radius * thickness_factor(kPi * radius / std::sqrt(3), 0.5);
    EXPECT_NEAR(force.mean(), wanted, 0.02 * wanted);
  }
}

// A tool that turns on the spot has no direction. Its force is bounded, and its work is exact.
TEST(Chip, OfAToolThatSpinsHasNoDirection) {
  Bench bench(Vec3(16, 16, 8), 0.25, {of_law({30, 10, 7}, 0.5)});
  DirectTool stroke(bench.model, Pose{Vec3(8.1, 7.9, 5), Mat3::Identity()});
  stroke.set_grain(&bench.grain);
  double largest = 0;
  for (int j = 1; j <= 60; j++) {
    const ToolTick tick =
        go(stroke, bench, BoxTool{Vec3(6, 1, 5)}, Vec3(8.1, 7.9, 5), 0, Vec3(0, 0, 0.02));
    EXPECT_TRUE(tick.wrench.force.allFinite() && tick.wrench.moment.allFinite());
    EXPECT_EQ(stroke.chip().moves, 0);
    if (j > 30) largest = std::max(largest, tick.wrench.moment.norm());
  }
  EXPECT_GT(largest, 0);
  // Both ends of the bar cut chips 3 mm wide and up to 3 mm high.
  EXPECT_LT(largest, 30 * 20 * 6);
}

// The thrust of a chisel pushes it out of the wood and does no work.
TEST(Chip, ThrustPushesAcrossTheMotion) {
  for (const double lean : {0.0, 0.5}) {
    Bench bench(Vec3(24, 24, 6), 0.2, {of_law({10, 10, 10}, 0.5)});
    const Vec3 start(9, 12, 5.2);
    DirectTool stroke(bench.model, Pose{start, frame_from_axis(Vec3::UnitZ(), 0)});
    stroke.set_grain(&bench.grain);
    Figures up, along;
    for (int j = 1; j <= 120; j++) {
      const Vec3 to = start + Vec3(0.03 * j, 0, -0.03 * lean * j * 0.1);
      const ToolTick tick = go(stroke, bench, BallTool{2}, to, kSharpThrust);
      const Vec3 p = tick.motion.travel.normalized();
      if (j <= 60) continue;
      up.add(tick.wrench.force.z() - tick.wrench.force.dot(p) * p.z());
      along.add(-tick.wrench.force.dot(p));
      EXPECT_NEAR(tick.wrench.force.y(), 0, 0.05 * along.mean());
    }
    EXPECT_GT(up.mean(), 0.05 * along.mean());
    EXPECT_LT(up.mean(), 0.3 * along.mean());
  }
}

// The force changes little from tick to tick while the cut changes smoothly.
TEST(Chip, ForcesDoNotJump) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int i = 0; i < 6; i++) {
    Bench bench(Vec3(30, 24, 6), 0.25, {of_law({30, 10, 7}, 0.5)}, random.direction());
    const double lift = random.uniform(0, 0.25), turn = random.uniform(-0.6, 0.6);
    Vec3 at(4, 12, 6.3 + lift);
    DirectTool stroke(bench.model, Pose{at, Mat3::Identity()});
    stroke.set_grain(&bench.grain);
    double last = 0, largest = 0, jump = 0;
    // Down into the wood and out again, on a curve.
    for (int j = 1; j <= 600; j++) {
      const double s = j / 600.0, heading = turn * std::sin(2 * kPi * s);
      at += 0.035 * Vec3(std::cos(heading), std::sin(heading), 0);
      at.z() = 6.3 + lift - 1.8 * std::sin(kPi * s);
      const double force = go(stroke, bench, BallTool{2.5}, at, kSharpThrust).wrench.force.norm();
      jump = std::max(jump, std::abs(force - last));
      largest = std::max(largest, force);
      last = force;
    }
    EXPECT_LT(jump, 0.05 * largest) << i;
  }
}

}  // namespace
}  // namespace kibori::chip_tests
