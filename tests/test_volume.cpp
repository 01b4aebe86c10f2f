// SPDX-License-Identifier: MIT
// Volumes and their forces, for shapes anywhere on the lattice: against closed forms, with stocks
// that are not multiples of the pitch and cuts thinner than a cell.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/haptics/path_mean.h>
#include <kibori/measure/mass.h>
#include <kibori/motion/direct_tool.h>

#include "tests/plain_material.h"
#include "tests/support.h"

namespace kibori::volume_tests {
namespace {

using test::Random;

constexpr double kPi = 3.14159265358979323846;

TriDexel block_of(const Vec3& size, double pitch, double room = 0) {
  TriDexel model(make_lattice(size, pitch, room).value());
  model.fill_block({Vec3::Zero(), size}, 0);
  return model;
}

std::vector<Material> energy_of(double u) { return {test::plain_material("test", 0.001, u)}; }

ToolTick go(DirectTool& stroke, const Tool& tool, const Vec3& to, const std::vector<Material>& of,
            const Vec3& turn = Vec3::Zero(), Mode mode = Mode::cut) {
  Result<ToolTick> tick = stroke.advance(tool, to, turn, mode, {ForceModel::energy, 6}, of);
  EXPECT_TRUE(tick) << tick.error();
  return tick.value();
}

TEST(Volume, OfABlockDoesNotDependOnThePitch) {
  for (const double pitch : {0.7, 0.53, 0.5, 0.4, 0.31, 0.25, 0.2, 0.13}) {
    const TriDexel cube = block_of(Vec3::Constant(10.24), pitch);
    const double wanted = std::pow(10.24, 3);
    EXPECT_NEAR(cube.volume_mm3(), wanted, 0.004 * wanted) << pitch;
    const TriDexel plate = block_of(Vec3(30.1, 20.3, 5.2), pitch);
    EXPECT_NEAR(plate.volume_mm3(), 30.1 * 20.3 * 5.2, 0.003 * 30.1 * 20.3 * 5.2) << pitch;
    const MassProperties mass = mass_of(plate.snapshot(), {1000});
    EXPECT_NEAR(mass.volume_mm3[0], plate.volume_mm3(), 1e-9 * plate.volume_mm3());
    EXPECT_NEAR(mass.centre_mm.x(), 15.05, 0.01 * pitch) << pitch;
    EXPECT_NEAR(mass.centre_mm.y(), 10.15, 0.01 * pitch) << pitch;
    EXPECT_NEAR(mass.centre_mm.z(), 2.6, 0.03 * pitch) << pitch;
  }
}

// Faces that are on, slightly before or slightly after planes of nodes and of cell borders, on all
// six sides.
TEST(Volume, OfABlockWhoseFacesLieOnNodes) {
  for (int side = 0; side < 6; side++)
    for (const double place : {0.5, 0.0, 0.25})
      for (const double off : {0.0, 1e-15, -1e-15, 1e-9, -1e-9, 1e-6, -1e-6, 1e-4, -1e-4}) {
        TriDexel model(make_lattice(Vec3::Constant(16), 1, 0).value());
        Box box{Vec3::Constant(3.3), Vec3::Constant(11.4)};
        (side < 3 ? box.min : box.max)[side % 3] = (side < 3 ? 4 : 12) + place + off;
        model.fill_block(box, 0);
        const Vec3 size = box.max - box.min;
        // Errors at its edges are of second order.
        EXPECT_NEAR(model.volume_mm3(), size.prod(), 0.01 * size.prod())
            << side << " " << place << " " << off;
      }
}

TEST(Volume, RemovedByACutterDoesNotDependOnThePitch) {
  for (const double pitch : {0.7, 0.53, 0.4, 0.31, 0.25, 0.2, 0.13, 0.1}) {
    TriDexel model = block_of(Vec3(30.1, 20.3, 5.2), pitch);
    DirectTool stroke(model, Pose{Vec3(-4, 10.15, 3.33), Mat3::Identity()});
    double removed = 0;
    const double before = model.volume_mm3();
    for (int i = 1; i <= 100; i++)
      removed +=
          go(stroke, Flat{3.1, 20}, Vec3(-4 + 0.38 * i, 10.15, 3.33), energy_of(1)).removed_mm3;
    const double wanted = 30.1 * 6.2 * (5.2 - 3.33);
    EXPECT_NEAR(removed, wanted, 0.005 * wanted) << pitch;
    EXPECT_NEAR(removed + model.volume_mm3(), before, 1e-6 * before) << pitch;
  }
}

// The mean force of a steady cut is u times its section, from a quarter of a cell on.
TEST(Volume, AChiselResistsByItsSection) {
  for (const double depth : {0.05, 0.09, 0.10, 0.15, 0.20, 0.25, 0.30, 0.50, 1.0}) {
    const double pitch = 0.2, width = 10.03, step = 0.0537;
    TriDexel model = block_of(Vec3(40.1, 20.3, 6.07), pitch);
    DirectTool stroke(model, Pose{Vec3(-6, 10.15, 6.07 - depth), Mat3::Identity()});
    double work = 0, path = 0, squares = 0;
    int ticks = 0;
    for (int i = 1; i <= 700; i++) {
      const ToolTick tick = go(stroke, BoxTool{Vec3(3, width, 20)},
                               stroke.pose().tip + Vec3(step, 0, 0), energy_of(1));
      const double at = stroke.pose().tip.x();
      if (at < 5 || at > 25) continue;
      const double force = -tick.wrench.force.x();
      work += force * step;
      path += step;
      squares += (force / (width * depth) - 1) * (force / (width * depth) - 1);
      ticks++;
    }
    const double wanted = width * depth, cells = depth / pitch;
    EXPECT_NEAR(work / path, wanted, (cells < 0.5 ? 0.03 : 0.015) * wanted) << depth;
    EXPECT_LT(std::sqrt(squares / ticks), cells >= 1.5 ? 0.05 : 0.25) << depth;
  }
}

// Positions at whole cells and simple fractions of a cell, so that faces are on planes of nodes.
TEST(Volume, AChiselAtWholePositionsResistsByItsSection) {
  for (const double depth : {0.05, 0.09, 0.10, 0.15, 0.20, 0.25, 0.30, 0.50}) {
    TriDexel model = block_of(Vec3(40, 20, 6), 0.2, 2);
    DirectTool stroke(model, Pose{Vec3(-6, 10, 6 - depth), Mat3::Identity()});
    for (int i = 1; i <= 600; i++) {
      const double x = -6 + 0.05 * i;
      const ToolTick tick =
          go(stroke, BoxTool{Vec3(3, 10, 20)}, Vec3(x, 10, 6 - depth), energy_of(1));
      if (x <= 5) continue;
      ASSERT_NEAR(-tick.wrench.force.x(), 10 * depth, 0.01 * 10 * depth) << depth;
    }
  }
}

// Steps and depths that are simple fractions of a cell: the faces of the tool pass the planes of
// nodes and the borders of tiles exactly, and some edges lie on two planes.
TEST(Volume, CutsAlongTheAxesAddUpToWhatIsMissing) {
  const double size = 12, pitch = 0.2, side = 4;
  const TriDexel whole = block_of(Vec3::Constant(size), pitch, 3);
  for (const int axis : {0, 1, 2})
    for (const double sign : {1.0, -1.0})
      for (const double step : {0.05, 0.1, 0.2, 0.25})
        for (const double depth : {0.1, 0.15, 0.5}) {
          SCOPED_TRACE(testing::Message() << axis << " " << sign << " " << step << " " << depth);
          const int down = (axis + 1) % 3, across = (axis + 2) % 3;
          TriDexel model(whole.snapshot(), whole.material_bounds());
          Vec3 tip, displacement = Vec3::Zero();
          tip[axis] = size / 2 - sign * (size / 2 + side / 2 + 0.3);
          tip[across] = 6;
          // The middle of the cutter.
          tip[down] = size - depth + side / 2;
          displacement[axis] = sign * step;
          // The cutter's tip is the middle of its bottom.
          tip.z() -= side / 2;
          DirectTool stroke(model, Pose{tip, Mat3::Identity()});
          const double before = model.volume_mm3();
          double removed = 0, work = 0;
          const int ticks = static_cast<int>(std::ceil((size + side + 0.6) / step));
          for (int i = 1; i <= ticks; i++) {
            const ToolTick tick =
                go(stroke, BoxTool{Vec3::Constant(side)}, tip + i * displacement, energy_of(1));
            removed += tick.removed_mm3;
            work -= sign * tick.wrench.force[axis] * step;
            ASSERT_NEAR(before - model.volume_mm3(), removed, 1e-6 * before) << "tick " << i;
          }
          EXPECT_NEAR(work, size * side * depth, 0.04 * size * side * depth);
        }
}

TEST(Volume, TheMeanOverThePathTakesAnyPath) {
  for (const double cells : {1e-9, 1e-3, 0.3, 1.0, 2.7, 40.0, 1e9, 1e18, 1e30}) {
    PathMean mean;
    PathMean::Resistance all;
    all.volume = 7;
    all.force = Vec3(1, 2, 3);
    mean.put(0, all, cells);
    double paid = 0, force = 0;
    const auto pay = [&](double path) {
      mean.pay(path);
      mean.for_paid([&](int, const PathMean::Resistance& part) {
        paid += part.volume;
        force += part.force.z() * path;
      });
    };
    pay(cells);
    for (int i = 0; i < 20; i++) pay(0.1);
    EXPECT_NEAR(paid, 7, 1e-6) << cells;
    EXPECT_NEAR(force, 3 * cells, 1e-6 * cells) << cells;
    EXPECT_NEAR(mean.unpaid(), 0, 1e-6) << cells;
  }
}

TEST(Volume, RandomCutsAddUpToWhatIsMissing) {
  Random random;
  SCOPED_TRACE(random.note());
  TriDexel model = block_of(Vec3(21.3, 17.7, 11.9), 0.37, 1);
  const double before = model.volume_mm3();
  double removed = 0;
  const int edits = test::rounds_of("KIBORI_VOLUME_EDITS", 400);
  for (int i = 0; i < edits; i++) {
    const Vec3 at(random.uniform(0, 21), random.uniform(0, 18), random.uniform(6, 13));
    DirectTool stroke(model, Pose{at, rotation(random.direction() * random.uniform(0, 3))});
    const bool ball = random.uniform(0, 1) < 0.5;
    const Vec3 displacement = random.direction() * random.uniform(0, 2);
    const Vec3 turn = random.direction() * (random.uniform(0, 1) < 0.5 ? 0 : 0.1);
    const Mode mode = random.uniform(0, 1) < 0.3 ? Mode::deposit : Mode::cut;
    removed +=
        go(stroke, ball ? Tool(BallTool{random.uniform(0.1, 2)}) : Tool(BoxTool{Vec3(2, 1, 3)}),
           at + displacement, energy_of(1), turn, mode)
            .removed_mm3;
  }
  EXPECT_NEAR(removed + model.volume_mm3(), before, 1e-6 * before);
}

// Pockets are cut in passes. The walls and floors of all passes are on the same planes of nodes.
TEST(Volume, PassesSideBySideOnNodesAddUp) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int round = 0; round < 40; round++) {
    const double pitch = random.integer(0, 1) ? 0.5 : 0.31;
    TriDexel model = block_of(Vec3(30.1, 20.1, 10), pitch, 1);
    const auto to_node = [&](double x) { return pitch * (std::floor(x / pitch) + 0.5); };
    double before = model.volume_mm3();
    for (int pass = 0; pass < 8; pass++) {
      const double width = to_node(random.uniform(2, 4));
      const Tool tool = random.integer(0, 1) ? Tool(BoxTool{Vec3(width, to_node(4), 12)})
                                             : Tool(Flat{width / 2, 12});
      const Vec3 at = model.lattice().origin_mm + Vec3(to_node(random.uniform(0, 28)),
                                                       to_node(random.uniform(0, 18)),
                                                       to_node(random.uniform(4, 9)));
      const double path = pitch * std::round(random.uniform(-6, 6) / pitch);
      DirectTool stroke(model, Pose{at, rotation(Vec3::Zero())});
      const double removed =
          go(stroke, tool, at + path * Vec3::Unit(random.integer(0, 1)), energy_of(1)).removed_mm3;
      const double now = model.volume_mm3();
      ASSERT_NEAR(before - now, removed, 1e-6 * before) << "round " << round << ", pass " << pass;
      before = now;
    }
  }
}

}  // namespace
}  // namespace kibori::volume_tests
