// SPDX-License-Identifier: MIT
// Forces of steady cuts and of smooth changes, at random poses and lattice offsets. The oracles are
// closed forms; they share no code with the kernel.
//
// KIBORI_POSES: number of poses per row. KIBORI_PASSIVE_TICKS: number of random ticks.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/haptics/passivity.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/spring_tool.h>

#include "tests/plain_material.h"
#include "tests/pose_support.h"
#include "tests/support.h"

namespace kibori::force_poses_tests {
namespace {

using namespace test;

constexpr double kPi = std::numbers::pi;

int poses() { return rounds_of("KIBORI_POSES", 24); }

Material wood(std::array<double, 3> k, double m) {
  Material material;
  material.k = k;
  material.m = m;
  return material;
}

const std::vector<Material> kPlain{plain_material("test", 0.001, 1)};

ToolTick go(DirectTool& stroke, const Tool& tool, const Vec3& to,
            const std::vector<Material>& materials, const Vec3& turn = Vec3::Zero(),
            double thrust = 0) {
  ForceLaw law{ForceModel::energy, 6};
  law.thrust = thrust;
  Result<ToolTick> tick = stroke.advance(tool, to, turn, Mode::cut, law, materials);
  EXPECT_TRUE(tick) << tick.error();
  return tick.value();
}

// Errors of one kind of steady cut, over many poses.
struct Steady {
  Errors bias;         // of the mean force of each pose [%]
  Errors ripple, raw;  // of single ticks relative to that mean: force, and removed volume [%]
};

// A cut along the x axis of `frame`, `depth` below a face whose normal is its z axis.
struct Cut {
  Tool tool;
  double section, width, depth;  // [mm], [mm^2]
  Mat3 frame;
  double pitch;
  double step;  // [cells]
};

void add_steady(Random& random, const Cut& cut, Steady& steady) {
  const double reach = cut.width / 2 + 6 * cut.pitch;
  PlacedBox stock;
  stock.centre = random.in_box(-5, 5);
  stock.frame = cut.frame;
  const double step = cut.step * cut.pitch;
  // Skips ticks until the front of the cut is complete and the window of the mean is full.
  const int skipped = static_cast<int>(std::ceil(1.5 / cut.step)) + 2;
  const int ticks = static_cast<int>(std::ceil(8 / cut.step));
  const double ahead = (skipped + ticks) * step;
  stock.size = Vec3(2 * reach + ahead, cut.width + 6 * cut.pitch, cut.depth + 5 * cut.pitch);
  TriDexel model(random_lattice(random, stock.centre, stock.size, cut.pitch));
  add_tool(model, stock.tool(), stock.pose());
  const Vec3 along = cut.frame.col(0);
  const Vec3 start =
      stock.at(Vec3(-ahead / 2, random.uniform(-1, 1) * cut.pitch, stock.size.z() / 2 - cut.depth));
  DirectTool stroke(model, Pose{start, cut.frame});
  std::vector<double> forces, sections;
  for (int i = 1; i <= skipped + ticks; i++) {
    const ToolTick tick = go(stroke, cut.tool, start + i * step * along, kPlain);
    EXPECT_LT(tick.wrench.force.cross(along).norm(), 1e-9 + 1e-9 * tick.wrench.force.norm());
    if (i <= skipped) continue;
    forces.push_back(-tick.wrench.force.dot(along));
    sections.push_back(tick.removed_mm3 / step);
  }
  double mean = 0, mean_section = 0;
  for (const double force : forces) mean += force / ticks;
  for (const double section : sections) mean_section += section / ticks;
  steady.bias.add(100 * (mean / cut.section - 1));
  for (const double force : forces) steady.ripple.add(100 * (force / mean - 1));
  for (const double section : sections) steady.raw.add(100 * (section / mean_section - 1));
}

void print_row(const char* name, const Steady& steady) {
  std::printf("%-40s bias %+6.2f  rms %5.2f  ripple raw %5.1f  mean over a cell %5.2f %%\n", name,
              steady.bias.mean(), steady.bias.rms(), steady.raw.rms(), steady.ripple.rms());
}

// The last table of the method's section 1: steps of 0.15 cells over a face on the lattice.
TEST(ForcePoses, SteadyCutsOfTheMethod) {
  Random random;
  SCOPED_TRACE(random.note());
  struct Row {
    bool ball;
    double depth;                      // [cells]
    std::array<double, 2> bias, mean;  // of the method [%]: along x, at 23 degrees
  };
  const Row rows[] = {{true, 0.6, {1.7, 1.5}, {1.4, 3.1}},  {true, 1.5, {0.2, 0.7}, {1.0, 2.1}},
                      {true, 4.3, {0.1, 0.2}, {0.5, 1.2}},  {false, 0.6, {-0.5, 0.5}, {7.2, 13}},
                      {false, 1.5, {0.7, 0.1}, {2.3, 4.6}}, {false, 4.3, {0, 0}, {0.5, 1.1}}};
  for (const Row& row : rows)
    for (const bool oblique : {false, true}) {
      const size_t i = oblique ? 1 : 0;
      Steady steady;
      for (int pose = 0; pose < poses(); pose++) {
        const double pitch = random.uniform(0.1, 1), depth = row.depth * pitch;
        const double radius = (row.ball ? 8 : 6.2) * pitch, turn = oblique ? 23 * kPi / 180 : 0;
        Mat3 frame = random_axes(random);
        frame = Mat3(frame * Eigen::AngleAxisd(turn, Vec3::UnitZ()).toRotationMatrix());
        add_steady(random,
                   {row.ball ? Tool(BallTool{radius}) : Tool(Flat{radius, 20 * pitch}),
                    row.ball ? segment_area(radius, depth) : 2 * radius * depth, 2 * radius, depth,
                    frame, pitch, 0.15},
                   steady);
      }
      char name[80];
      std::snprintf(name, sizeof name, "%s, depth %.1f, %s", row.ball ? "ball R 8" : "mill R 6.2",
                    row.depth, oblique ? "at 23 degrees" : "along an axis");
      std::printf("method %+4.1f, %4.1f: ", row.bias[i], row.mean[i]);
      print_row(name, steady);
      EXPECT_LT(std::abs(steady.bias.mean()), steady.bias.mean_bound(row.depth < 1.5 ? 2.5 : 1))
          << name;
      if (row.depth >= 1.5) {
        EXPECT_LT(steady.ripple.rms(), row.ball ? 3 : 5) << name;
      }
    }
}

// Every kind of tool, in any frame, with any step, by the mean thickness of the cut. A gouge has a
// flat front.
TEST(ForcePoses, SteadyCutsOfEveryTool) {
  Random random;
  SCOPED_TRACE(random.note());
  for (const Kind kind : kKinds)
    for (const Lie lie : kLies)
      for (const auto& [thin, thick] : {std::pair(0.5, 1.5), {1.5, 4.0}, {4.0, 15.0}}) {
        // A tetrahedron is narrow where it is thin.
        if (kind == Kind::tetrahedron && thin < 4) continue;
        Steady steady;
        const int count = std::max(4, poses() / (thin < 4 ? 2 : 4));
        for (int i = 0; i < count; i++) {
          const double pitch = random.uniform(0.1, 1);
          const double depth = depth_of(kind) * pitch * random.uniform(thin, thick);
          const Cutter cutter = random_cutter(random, kind, pitch, depth, 8 * pitch);
          add_steady(random,
                     {cutter.tool, cutter.section, cutter.width, depth, random_frame(random, lie),
                      pitch, i % 4 == 3 ? random.uniform(0.8, 2.5) : random.uniform(0.1, 0.5)},
                     steady);
        }
        char name[80];
        std::snprintf(name, sizeof name, "%s %g-%g, %s", name_of_kind(kind), thin, thick,
                      name_of_lie(lie));
        print_row(name, steady);
        EXPECT_LT(std::abs(steady.bias.mean()), steady.bias.mean_bound(thin < 1.5 ? 2.5 : 1))
            << name;
        const bool round = kind == Kind::ball || kind == Kind::cone;
        if (thin >= 1.5) {
          EXPECT_LT(steady.ripple.rms(), (round ? 3 : 5) * scatter(count)) << name;
        }
      }
}

// Steps of several cells. The force of each tick is that of its own volume.
TEST(ForcePoses, StepsLongerThanACell) {
  Random random;
  SCOPED_TRACE(random.note());
  for (const double step : {0.9, 1.0, 1.7, 3.0, 6.3}) {
    Steady steady;
    for (int i = 0; i < poses(); i++) {
      const double pitch = random.uniform(0.1, 1), depth = pitch * random.uniform(1.5, 5);
      const Cutter cutter = random_cutter(random, Kind::ball, pitch, depth);
      add_steady(random,
                 {cutter.tool, cutter.section, cutter.width, depth,
                  random_frame(random, kLies[i % 3]), pitch, step},
                 steady);
    }
    char name[80];
    std::snprintf(name, sizeof name, "ball, steps of %.1f cells", step);
    print_row(name, steady);
    EXPECT_LT(std::abs(steady.bias.mean()), steady.bias.mean_bound(1)) << step;
    EXPECT_LT(steady.ripple.rms(), 3) << step;
  }
}

// A tool that reverses moves in its own groove: no force, and no pending volume. If it moves
// forward again, the force returns when the tool passes the front of its cut.
TEST(ForcePoses, ReversalEmptiesTheMean) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int i = 0; i < poses(); i++) {
    const double pitch = random.uniform(0.1, 1), depth = pitch * random.uniform(1.5, 5);
    const Cutter cutter = random_cutter(random, kKinds[i % 6], pitch, depth, 8 * pitch);
    const PlacedBox stock{
        random.in_box(-5, 5),
        Vec3(2 * cutter.width + 40 * pitch, cutter.width + 6 * pitch, depth + 5 * pitch),
        random_frame(random, kLies[random.integer(0, 2)])};
    TriDexel model(random_lattice(random, stock.centre, stock.size, pitch));
    add_tool(model, stock.tool(), stock.pose());
    const Vec3 along = stock.frame.col(0), start = stock.at(Vec3(0, 0, stock.size.z() / 2 - depth));
    DirectTool stroke(model, Pose{start, stock.frame});
    const double step = 0.2 * pitch;
    for (int tick = 1; tick <= 20; tick++)
      go(stroke, cutter.tool, start + tick * step * along, kPlain);
    EXPECT_GT(stroke.unpaid_cells(), 0);
    const double section = cutter.section / (pitch * pitch);
    for (int tick = 19; tick >= 10; tick--) {
      const ToolTick back = go(stroke, cutter.tool, start + tick * step * along, kPlain);
      // Rounding of the ends at the sides of the groove.
      EXPECT_NEAR(back.removed_mm3, 0, 1e-4 * cutter.section * pitch);
      EXPECT_LT(back.wrench.force.norm(), 1e-3 * cutter.section);
      EXPECT_NEAR(stroke.unpaid_cells(), 0, 1e-3 * section);
    }
    double mean = 0;
    for (int tick = 11; tick <= 40; tick++) {
      const ToolTick on = go(stroke, cutter.tool, start + tick * step * along, kPlain);
      const double force = -on.wrench.force.dot(along);
      if (tick <= 20) {
        EXPECT_LT(std::abs(force), 1e-3 * cutter.section);
      }
      if (tick > 30) mean += force / 10;
    }
    EXPECT_NEAR(mean, cutter.section, 0.15 * cutter.section) << name_of_kind(kKinds[i % 6]);
  }
}

// Width w and thickness t of chips, against the figures in the method's section 5a. For the chisel
// at 0.45 cells, it states an error of 0.1 %. For t, this holds only for the mean over positions. A
// cut of 0.45 cells has one layer of rays or none, and its sides are known only to a fraction of a
// row. The kernel's rms error is 0.4 % for t and 1 % for w.
TEST(ForcePoses, ChipsOfTheMethod) {
  Random random;
  SCOPED_TRACE(random.note());
  const std::vector<Material> materials{wood({10, 10, 10}, 0.5)};
  struct Row {
    bool ball;
    double depth, bound;  // [cells], [%]
  };
  for (const Row& row :
       {Row{false, 0.45, 2.5}, {false, 1.5, 1}, {false, 5, 0.5}, {true, 1.5, 1.5}, {true, 4, 1}}) {
    Errors section, width, thickness;
    for (int i = 0; i < poses(); i++) {
      const double pitch = 0.2, depth = row.depth * pitch, radius = 8 * pitch;
      const double wide = row.ball ? 2 * radius : 25 * pitch;
      const Tool tool = row.ball ? Tool(BallTool{radius}) : Tool(BoxTool{Vec3(2, wide, 8)});
      const Mat3 frame = random_frame(random, kLies[i % 3]);
      const PlacedBox stock{random.in_box(-5, 5), Vec3(9, wide + 1.2, depth + 1.5), frame};
      TriDexel model(random_lattice(random, stock.centre, stock.size, pitch));
      add_tool(model, stock.tool(), stock.pose());
      const Vec3 start = stock.at(Vec3(-1, 0, stock.size.z() / 2 - depth));
      DirectTool stroke(model, Pose{start, frame});
      // The variance of the section's width by slices: exact for the rectangle.
      double area = 0, variance = 0;
      for (int slice = 0; slice < 20000; slice++) {
        const double y = wide * ((slice + 0.5) / 20000 - 0.5);
        const double high =
            row.ball ? std::sqrt(radius * radius - y * y) - (radius - depth) : depth;
        if (high > 0) area += high * wide / 20000;
        if (high > 0) variance += high * y * y * wide / 20000;
      }
      const double w = std::sqrt(12 * variance / area);
      double s = 0, sum_w = 0, sum_t = 0;
      constexpr int kTicks = 60;
      for (int tick = 1; tick <= 20 + kTicks; tick++) {
        go(stroke, tool, start + 0.15 * pitch * tick * frame.col(0), materials);
        if (tick <= 20) continue;
        s += stroke.chip().section_mm2 / kTicks;
        sum_w += stroke.chip().width_mm / kTicks;
        sum_t += stroke.chip().thickness_mm / kTicks;
      }
      section.add(100 * (s / area - 1));
      width.add(100 * (sum_w / w - 1));
      thickness.add(100 * (sum_t / (area / w) - 1));
    }
    std::printf("%s %.2f deep: S %+.2f rms %.2f, w %+.2f rms %.2f, t %+.2f rms %.2f %%\n",
                row.ball ? "ball R 8," : "chisel 25 wide,", row.depth, section.mean(),
                section.rms(), width.mean(), width.rms(), thickness.mean(), thickness.rms());
    EXPECT_LT(section.rms(), row.bound) << row.depth;
    EXPECT_LT(width.rms(), row.bound) << row.depth;
    EXPECT_LT(thickness.rms(), row.bound) << row.depth;
  }
}

// One wood, entered as two materials that meet anywhere in the chip, resists as one.
TEST(ForcePoses, OneWoodInTwoLayersInAnyFrame) {
  Random random;
  SCOPED_TRACE(random.note());
  const std::vector<Material> materials(2, wood({10, 10, 10}, 0.5));
  Errors errors;
  for (int i = 0; i < poses(); i++) {
    const double pitch = 0.2, depth = pitch * random.uniform(2, 5), width = 25 * pitch;
    const PlacedBox stock{random.in_box(-5, 5), Vec3(9, width + 1.2, depth + 1.5),
                          random_frame(random, kLies[i % 3])};
    TriDexel model(random_lattice(random, stock.centre, stock.size, pitch));
    add_tool(model, stock.tool(), stock.pose());
    const Vec3 face = stock.at(Vec3(0, 0, stock.size.z() / 2 - depth * random.uniform(0.1, 0.9)));
    const Vec3 lean = i % 2 ? Vec3(0.2 * random.direction()) : Vec3(Vec3::Zero());
    cut_tool(model, BoxTool{Vec3::Constant(40)},
             {face, frame_from_axis(stock.frame.col(2) + lean)});
    add_tool(model, stock.tool(), stock.pose(), 1);
    const Vec3 start = stock.at(Vec3(-1, 0, stock.size.z() / 2 - depth));
    DirectTool stroke(model, Pose{start, stock.frame});
    double mean = 0;
    for (int tick = 1; tick <= 80; tick++) {
      const Vec3 to = start + 0.15 * pitch * tick * stock.frame.col(0);
      const ToolTick on = go(stroke, BoxTool{Vec3(2, width, 8)}, to, materials);
      if (tick > 20) mean -= on.wrench.force.dot(stock.frame.col(0)) / 60;
    }
    errors.add(100 * (mean / (10 * width * std::sqrt(depth)) - 1));
  }
  std::printf("one wood in two layers: force %+.2f, rms %.2f, max %.2f %%\n", errors.mean(),
              errors.rms(), errors.largest());
  EXPECT_LT(std::abs(errors.mean()), errors.mean_bound(1));
  EXPECT_LT(errors.largest(), 4);
}

// A chisel over two rails cuts two strips. Each resists as it would alone. In oblique frames the
// width of the gap follows from cells along three axes. So the force is 2 to 3 % too small on
// average.
TEST(ForcePoses, TwoStripsInAnyFrame) {
  Random random;
  SCOPED_TRACE(random.note());
  const std::vector<Material> materials{wood({10, 10, 10}, 0.5)};
  for (const Lie lie : kLies) {
    Errors errors;
    for (int i = 0; i < (poses() + 2) / 3; i++) {
      const double pitch = 0.25, depth = pitch * random.uniform(2, 4);
      const double strip = pitch * random.uniform(6, 12), gap = pitch * random.uniform(8, 30);
      const double width = 2 * strip + gap;
      const PlacedBox stock{random.in_box(-5, 5), Vec3(10, width, depth + 1.5),
                            random_frame(random, lie)};
      TriDexel model(random_lattice(random, stock.centre, stock.size, pitch));
      add_tool(model, stock.tool(), stock.pose());
      cut_tool(model, BoxTool{Vec3(20, gap, 20)},
               {stock.at(Vec3(0, 0, stock.size.z() / 2 - depth - 2 * pitch)), stock.frame});
      const Vec3 start = stock.at(Vec3(-2, 0, stock.size.z() / 2 - depth));
      DirectTool stroke(model, Pose{start, stock.frame});
      double mean = 0;
      for (int tick = 1; tick <= 80; tick++) {
        const Vec3 to = start + 0.15 * pitch * tick * stock.frame.col(0);
        const ToolTick on = go(stroke, BoxTool{Vec3(2, width + 2, 8)}, to, materials);
        if (tick > 20) mean -= on.wrench.force.dot(stock.frame.col(0)) / 60;
      }
      errors.add(100 * (mean / (10 * 2 * strip * std::sqrt(depth)) - 1));
    }
    std::printf("two strips, %s: force %+.2f, rms %.2f, max %.2f %%\n", name_of_lie(lie),
                errors.mean(), errors.rms(), errors.largest());
    EXPECT_LT(errors.rms(), (lie == Lie::oblique ? 5 : 3) * scatter(errors.count()))
        << name_of_lie(lie);
  }
}

// The section of a plunge is round: its width equals its thickness in any frame.
TEST(ForcePoses, APlungeIsRoundInAnyFrame) {
  Random random;
  SCOPED_TRACE(random.note());
  const std::vector<Material> materials{wood({18, 18, 18}, 0.5)};
  for (int i = 0; i < poses(); i++) {
    const double pitch = random.uniform(0.15, 0.4), radius = pitch * random.uniform(6, 12);
    const PlacedBox stock{random.in_box(-5, 5), Vec3(2.6 * radius, 2.6 * radius, 20 * pitch),
                          random_frame(random, kLies[i % 3])};
    TriDexel model(random_lattice(random, stock.centre, stock.size, pitch));
    add_tool(model, stock.tool(), stock.pose());
    const Vec3 down = -stock.frame.col(2);
    const Vec3 start = stock.at(Vec3(0, 0, stock.size.z() / 2 + 0.3 * pitch));
    DirectTool stroke(model, Pose{start, stock.frame});
    Errors force, width;
    const double w = std::sqrt(3.0) * radius, t = kPi * radius / std::sqrt(3.0);
    const double wanted = 18 * w * (t < 1 ? std::sqrt(t) : 1 + 0.5 * (t - 1));
    for (int tick = 1; tick <= 60; tick++) {
      const ToolTick on =
          go(stroke, Flat{radius, 40 * pitch}, start + 0.2 * pitch * tick * down, materials);
      if (tick <= 20) continue;
      force.add(100 * (-on.wrench.force.dot(down) / wanted - 1));
      width.add(100 * (stroke.chip().width_mm / w - 1));
    }
    EXPECT_LT(std::abs(force.mean()), 2);
    EXPECT_LT(force.deviation(), 5);
    EXPECT_LT(width.rms(), 2);
  }
}

// A bar that spins in place. Its moment is u times the volume per angle, until it has passed half a
// turn.
TEST(ForcePoses, ABarThatSpinsHasTheClosedForm) {
  Random random;
  SCOPED_TRACE(random.note());
  Errors bias;
  for (int i = 0; i < poses(); i++) {
    const double pitch = random.uniform(0.15, 0.6), half = pitch * random.uniform(8, 14),
                 thick = 3 * pitch, high = pitch * random.uniform(3, 8);
    const PlacedBox stock{random.in_box(-5, 5), Vec3(2.4 * half, 2.4 * half, high + 6 * pitch),
                          random_frame(random, kLies[i % 3])};
    TriDexel model(random_lattice(random, stock.centre, stock.size, pitch));
    add_tool(model, stock.tool(), stock.pose());
    const Vec3 tip = stock.at(Vec3(0, 0, stock.size.z() / 2 - high)), axis = stock.frame.col(2);
    DirectTool stroke(model, Pose{tip, stock.frame});
    const double turn = 0.02;
    double moment = 0, wanted = 0;
    // After a turn by twice this angle, the trailing corners are where the leading ones began.
    const double corner = std::atan(thick / 2 / half);
    for (int tick = 1; turn * tick < 2; tick++) {
      const ToolTick on =
          go(stroke, BoxTool{Vec3(2 * half, thick, high + 4 * pitch)}, tip, kPlain, turn * axis);
      EXPECT_TRUE(on.wrench.force.allFinite() && on.wrench.moment.allFinite());
      EXPECT_LE(on.wrench.moment.dot(axis), 1e-9);
      if (turn * tick < 2 * corner + 0.2) continue;
      moment -= on.wrench.moment.dot(axis);
      // The leading side of each half sweeps half^2 / 2 per radian. Near the axis, the other half
      // has already removed the material.
      const double passed = thick / 2 * std::tan(turn * (tick - 0.5) / 2);
      wanted += (half * half - passed * passed) * high;
    }
    bias.add(100 * (moment / wanted - 1));
  }
  std::printf("bar that spins: moment %+.2f, rms %.2f %%\n", bias.mean(), bias.rms());
  EXPECT_LT(std::abs(bias.mean()), bias.mean_bound(1));
  EXPECT_LT(bias.rms(), 2);
}

// ---- Continuity.

// A block of two woods that meet at a face in any direction.
struct TwoWoods {
  TriDexel model;
  std::vector<Material> materials{wood({33, 10, 7}, 0.5), wood({6, 6, 3}, 0.5)};

  TwoWoods(Random& random, const PlacedBox& stock, double pitch, const Pose& face)
      : model(random_lattice(random, stock.centre, stock.size, pitch)) {
    add_tool(model, stock.tool(), stock.pose());
    // The part beyond the face is cut off, and filled in as the other wood.
    cut_tool(model, BoxTool{Vec3::Constant(3 * stock.size.norm())}, face);
    add_tool(model, stock.tool(), stock.pose(), 1);
  }
};

// The force of smooth changes has no jumps above 5 % of its range. Depth, direction, pose and
// material change in all combinations.
//
// Model `series` misses this aim where a spring of 50 N/mm is pulled through hard wood: measured
// are jumps of 7 to 18 %. The path of a tick leads to the hand, which is four cells ahead and
// above. So the resistance falls along it, by up to 9 N per cell. The spring's pull falls by 12.5 N
// per cell, and the small difference of the two slopes makes each ripple four times as large.
TEST(ForcePoses, SmoothChangesHaveNoJumps) {
  Random random;
  SCOPED_TRACE(random.note());
  Errors jumps, series_jumps;
  for (int i = 0; i < std::max(6, poses() / 3); i++) {
    const double pitch = 0.25;
    const PlacedBox stock{random.in_box(-5, 5), Vec3(28, 24, 6),
                          random_frame(random, kLies[i % 3])};
    const Vec3 face = stock.frame * Vec3(1, random.uniform(-1, 1), random.uniform(0.3, 1));
    TwoWoods bench(random, stock, pitch, {stock.at(Vec3(0, 0, 2)), frame_from_axis(face)});
    const double heading = random.uniform(-0.6, 0.6), lean = random.uniform(-0.5, 0.5),
                 roll = random.uniform(-1, 1), sink = random.uniform(1, 1.8);
    const Tool tool = i % 2 ? Tool(BallTool{2.5}) : Tool(Ellipsoid{Vec3(2, 3, 2.5)});
    const auto place = [&](double s) {  // of the tip, in the stock's frame
      return Vec3(-10 + 20 * s, 8 / kPi * heading * (1 - std::cos(2 * kPi * s)),
                  3.3 - (sink + 0.3) * std::sin(kPi * s));
    };
    const auto turned = [&](double s) {
      return Mat3(stock.frame *
                  rotation(Vec3(0, lean * std::sin(kPi * s), roll * std::sin(kPi * s))));
    };
    DirectTool stroke(bench.model, Pose{stock.at(place(0)), turned(0)});
    // Every sixth run: model `series`.
    const bool series = i % 6 == 5;
    SeriesSpring stiff;
    stiff.stiffness_n_mm = 50;
    SpringTool spring(bench.model, stroke.pose(), stiff);
    double last = 0, largest = 0, jump = 0;
    constexpr int kTicks = 600;
    for (int tick = 1; tick <= kTicks; tick++) {
      const double s = static_cast<double>(tick) / kTicks;
      const Pose pose{stock.at(place(s)), turned(s)};
      Vec3 pull;
      if (series) {
        const Result<ToolTick> on = spring.advance(tool, pose, Mode::cut, bench.materials);
        ASSERT_TRUE(on) << on.error();
        pull = on.value().wrench.force;
      } else {
        const Vec3 turn = rotation_between(stroke.pose().frame, pose.frame);
        pull = go(stroke, tool, pose.tip, bench.materials, turn, kSharpThrust).wrench.force;
      }
      const double force = pull.norm();
      jump = std::max(jump, std::abs(force - last));
      largest = std::max(largest, force);
      last = force;
    }
    (series ? series_jumps : jumps).add(100 * jump / largest);
    EXPECT_LT(jump, (series ? 0.25 : 0.05) * largest) << i << (series ? ", series" : "");
  }
  std::printf("largest jumps: rms %.2f, max %.2f %% of the range; series: rms %.2f, max %.2f %%\n",
              jumps.rms(), jumps.largest(), series_jumps.rms(), series_jumps.largest());
}

// ---- Passivity.

// A random hand drives the spring's tool through woods of any kind. The spring holds its force over
// each tick, so a device must damp k T/2. Beyond that no energy is generated.
TEST(ForcePoses, RandomHandsGetNoEnergyFromTheSpring) {
  Random random;
  SCOPED_TRACE(random.note());
  const int ticks = rounds_of("KIBORI_PASSIVE_TICKS", 1500);
  double lowest = 0;
  for (int done = 0, hand = 0; done < ticks; hand++) {
    const double pitch = random.uniform(0.3, 0.8);
    const PlacedBox stock{random.in_box(-5, 5), Vec3(20, 16, 10),
                          random_frame(random, kLies[hand % 3])};
    TriDexel model(random_lattice(random, stock.centre, stock.size, pitch));
    add_tool(model, stock.tool(), stock.pose());
    Material material = random.integer(0, 1)
                            ? wood({33, 10, 7}, 0.5)
                            : plain_material("test", 0.001, random.uniform(0.02, 5));
    material.yield_n = random.integer(0, 1) ? random.uniform(0, 3) : 0;
    material.c = random.integer(0, 1) ? random.uniform(0, 0.002) : 0;
    SeriesSpring spring;
    spring.stiffness_n_mm = std::exp(random.uniform(std::log(0.2), std::log(20.0)));
    spring.friction = random.uniform(0, 0.5);
    if (random.integer(0, 3) == 0) spring.strength_n = random.uniform(5, 100);
    const Cutter cutter =
        random_cutter(random, kKinds[random.integer(0, 4)], pitch, pitch * random.uniform(2, 6));
    Pose device{stock.at(Vec3(0, 0, stock.size.z() / 2 + 3)), stock.frame};
    SpringTool tool(model, device, spring);
    PassivityObserver observer;
    // A point that wanders by small and large steps, and rests at times.
    Vec3 speed = Vec3::Zero(), target = device.tip;
    double damped = 0, scale = 1e-9;
    for (int tick = 0; tick < 500 && done < ticks; tick++, done++) {
      if (random.integer(0, 39) == 0)
        target = stock.at(random.in_box(-0.5, 0.6).cwiseProduct(stock.size));
      if (random.integer(0, 99) == 0) speed = random.direction() * random.uniform(0, 1);
      speed = Vec3(0.9 * speed + 0.01 * (target - device.tip) + random.in_box(-0.01, 0.01));
      const Vec3 step = random.integer(0, 19) == 0 ? Vec3(Vec3::Zero()) : speed;
      device.tip += step;
      if (hand % 2) device.frame = Mat3(rotation(random.in_box(-0.01, 0.01)) * device.frame);
      const Mode mode = random.integer(0, 29) == 0 ? Mode::touch : Mode::cut;
      const Result<ToolTick> result = tool.advance(cutter.tool, device, mode, {material});
      ASSERT_TRUE(result) << result.error();
      const Vec3 force = result.value().wrench.force;
      ASSERT_TRUE(force.allFinite());
      observer.tick(device.tip, force, 0.001);
      observer.given(force);
      damped += 0.5 * spring.stiffness_n_mm * step.squaredNorm();
      scale = std::max(scale, observer.energy_mj() + damped);
      ASSERT_GE(observer.energy_mj() + damped, -1e-6 * scale)
          << "hand " << hand << ", tick " << tick << ", " << shape_of(cutter.tool);
      lowest = std::min(lowest, (observer.energy_mj() + damped) / scale);
    }
  }
  std::printf("lowest energy: %.2g of the most\n", lowest);
}

// Model `energy`: no tick does work on the tool, whatever the motion.
TEST(ForcePoses, NoTickPushesTheTool) {
  Random random;
  SCOPED_TRACE(random.note());
  const int ticks = rounds_of("KIBORI_PASSIVE_TICKS", 1500);
  const std::vector<Material> materials{wood({33, 10, 7}, 0.5)};
  for (int done = 0, hand = 0; done < ticks; hand++) {
    const double pitch = random.uniform(0.3, 0.8);
    const PlacedBox stock{random.in_box(-5, 5), Vec3(20, 16, 10),
                          random_frame(random, kLies[hand % 3])};
    TriDexel model(random_lattice(random, stock.centre, stock.size, pitch));
    add_tool(model, stock.tool(), stock.pose());
    const Cutter cutter = random_cutter(random, kKinds[random.integer(0, kKindCount - 1)], pitch,
                                        pitch * random.uniform(2, 6));
    DirectTool stroke(model, {stock.at(Vec3(0, 0, stock.size.z() / 2 + 3)), stock.frame});
    Vec3 speed = Vec3::Zero(), target = stroke.pose().tip;
    for (int tick = 0; tick < 300 && done < ticks; tick++, done++) {
      if (random.integer(0, 39) == 0)
        target = stock.at(random.in_box(-0.5, 0.6).cwiseProduct(stock.size));
      speed = Vec3(0.9 * speed + 0.01 * (target - stroke.pose().tip) + random.in_box(-0.02, 0.02));
      const Vec3 turn = hand % 2 ? random.in_box(-0.02, 0.02) : Vec3(Vec3::Zero());
      const ToolTick on = go(stroke, cutter.tool, stroke.pose().tip + speed,
                             random.integer(0, 1) ? materials : kPlain, turn);
      ASSERT_TRUE(on.wrench.force.allFinite() && on.wrench.moment.allFinite());
      const double work = on.wrench.force.dot(speed) + on.wrench.moment.dot(turn);
      ASSERT_LE(work, 1e-9 * (1 + on.wrench.force.norm())) << hand << " " << tick;
    }
  }
}

}  // namespace
}  // namespace kibori::force_poses_tests
