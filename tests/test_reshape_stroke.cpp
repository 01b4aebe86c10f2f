// SPDX-License-Identifier: MIT
// Reshaping strokes: warps, creases, paint and pressed clay along a tip's path, with images, and
// their force. Lengths in cells, at a pitch of 1 mm.
#include <cmath>

#include <gtest/gtest.h>

#include <kibori/body/pieces.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/reshape/clay.h>
#include <kibori/solid/ball.h>
#include <kibori/surface/surface.h>

#include "tests/every_tool.h"
#include "tests/reshape_support.h"
#include "tests/support.h"
#include "tests/surface_check.h"

namespace kibori::reshape_stroke_tests {
namespace {

constexpr double kPi = 3.14159265358979323846;

using test::add;
using test::cube;
using test::disagreeing;
using test::for_ends;
using test::Random;
using test::tool_at;

const std::vector<Material> kMaterials(3);

TriDexel block(int nodes, const Vec3& low, const Vec3& high) {
  TriDexel model(cube(nodes));
  model.fill_block({low, high}, 0);
  return model;
}

struct Sums {
  double removed = 0, work = 0, max_force = 0;
  int64_t points = 0;
};

// A stroke through `places`, with `ticks` ticks between two of them. It turns by `turn_rad` about
// the tool's axis over the whole path.
Sums stroke(TriDexel& model, const ReshapeSettings& settings, const std::vector<Vec3>& places,
            int ticks, double turn_rad = 0) {
  Sums sums;
  ReshapeStroke reshape(model);
  DirectTool tool(model, {places.front(), Mat3::Identity()});
  EXPECT_TRUE(reshape.begin(settings, kMaterials, tool.pose()).ok());
  const auto all = static_cast<double>(ticks) * static_cast<double>(places.size() - 1);
  for (size_t i = 1; i < places.size(); i++)
    for (int k = 1; k <= ticks; k++) {
      const Vec3 tip = places[i - 1] + (places[i] - places[i - 1]) * k / ticks;
      const Vec3 before = tool.pose().tip;
      auto tick = tool.advance(settings.tool, tip, turn_rad / all * Vec3::UnitZ(), settings.mode,
                               settings.law, kMaterials);
      EXPECT_TRUE(tick.ok()) << tick.error();
      const Status done = reshape.advance(tick.value());
      EXPECT_TRUE(done.ok()) << done.error();
      if (i + 1 == places.size() && k == ticks) {
        EXPECT_TRUE(reshape.end(tick.value()).ok());
      }
      sums.removed += tick.value().removed_mm3;
      sums.points += tick.value().points;
      sums.work -= tick.value().wrench.force.dot(tip - before);
      sums.max_force = std::max(sums.max_force, tick.value().wrench.force.norm());
    }
  return sums;
}

ReshapeSettings settings_of(Mode mode, double radius, double strength = 1) {
  ReshapeSettings s;
  s.mode = mode;
  s.brush.radius_mm = radius;
  s.brush.strength = strength;
  s.law = {ForceModel::energy, 6, 1};
  return s;
}

// A warp depends only on its end, not on the ticks or the path. Out and back leaves the same bytes.
TEST(ReshapeStroke, AWarpDependsOnItsEndAlone) {
  for (const Mode mode : {Mode::grab, Mode::nudge, Mode::twist, Mode::bend, Mode::pinch,
                          Mode::scale, Mode::node, Mode::grab_connected}) {
    const Vec3 at(32, 32, 40), to = at + Vec3(3, 2, 6);
    uint64_t hash = 0;
    double volume = 0;
    for (const int ticks : {1, 7, 300}) {
      TriDexel model = block(64, {8, 8, 8}, {56, 56, 40});
      const uint64_t before = model.content_hash();
      const double full = model.volume_mm3();
      const Sums sums =
          stroke(model, settings_of(mode, 12), {at, to}, ticks, mode == Mode::twist ? 0.8 : 0);
      if (ticks == 1) hash = model.content_hash();
      // Only the rounding of the turn's sum differs.
      if (mode != Mode::twist) {
        EXPECT_EQ(model.content_hash(), hash) << name_of(mode) << " in " << ticks;
      }
      if (ticks == 1) volume = model.volume_mm3();
      EXPECT_NEAR(model.volume_mm3(), volume, 1e-3);
      EXPECT_NEAR(sums.removed, full - model.volume_mm3(), 0.02) << name_of(mode);
      EXPECT_EQ(test::broken(extract_surface(model.snapshot())), "") << name_of(mode);
      // A flat top stays flat if it is turned about its normal.
      if (mode != Mode::twist) {
        EXPECT_NE(hash, before) << name_of(mode);
      }
      TriDexel back = block(64, {8, 8, 8}, {56, 56, 40});
      stroke(back, settings_of(mode, 12), {at, to, at}, ticks);
      EXPECT_EQ(back.content_hash(), before) << name_of(mode);
    }
  }
}

// A spring and a dashpot in series. At a constant speed F rises to k relax v, and falls to 0 when
// the hand stops. Its work over a closed path is never negative.
TEST(ReshapeStroke, AWarpsPullIsPassive) {
  MaxwellForce pull;
  const double k = 2, dt = 1e-3;
  Vec3 force = Vec3::Zero();
  for (int i = 0; i < 3000; i++) force = pull.pull(k, Vec3(0, 0, 0.01), dt);
  EXPECT_NEAR(force.z(), -k * MaxwellForce::kRelaxS * 10, 0.03);
  for (int i = 0; i < 2000; i++) force = pull.pull(k, Vec3::Zero(), dt);
  EXPECT_LT(force.norm(), 1e-4);
  Random random;
  pull.begin();
  double work = 0;
  for (int i = 0; i < 20000; i++) {
    const Vec3 path = random.in_box(-0.2, 0.2);
    work -= pull.pull(k, path, dt).dot(path);
    ASSERT_GE(work, 0) << random.note();
  }
  TriDexel model = block(64, {8, 8, 8}, {56, 56, 40});
  const Sums sums = stroke(model, settings_of(Mode::grab, 10), {{32, 32, 40}, {32, 32, 50}}, 200);
  EXPECT_GT(sums.work, 1);
  TriDexel counted = block(64, {8, 8, 8}, {56, 56, 40});
  ReshapeSettings paper = settings_of(Mode::grab, 10);
  paper.law = {ForceModel::paper, 5, 1};
  EXPECT_GT(stroke(counted, paper, {{32, 32, 40}, {32, 32, 50}}, 200).max_force, 0);
}

// Displaced material returns. The volume is kept to 1e-3 of the displaced volume, at any depth,
// also along rays. The furrow is open, and its bottom is where the tool was.
TEST(ReshapeStroke, ClayKeepsItsVolume) {
  for (const double depth : {0.5, 1.0, 3.0, 6.0})
    for (const int ticks : {12, 160}) {
      TriDexel model = block(96, {8, 8, 8}, {88, 88, 50});
      const double before = model.volume_mm3();
      ReshapeSettings s = settings_of(Mode::press, 5);
      s.tool = BallTool{8};
      const double z = 50 - depth;
      const Sums sums = stroke(model, s, {{30, 48, 60}, {30, 48, z}, {66, 48, z}}, ticks);
      const double displaced = 36 * depth * std::sqrt(2 * 8 * depth);  // approximately
      EXPECT_NEAR(model.volume_mm3(), before, 1e-3 * displaced) << depth;
      EXPECT_NEAR(sums.removed, before - model.volume_mm3(), 1e-2) << depth;
      EXPECT_EQ(disagreeing(model), 0);
      EXPECT_EQ(test::broken(extract_surface(model.snapshot())), "");
      EXPECT_GT(sums.work, 0);
      double bottom = 0;
      model.field(Axis::z).view().for_spans(
          48, 48, [&](const Span& span) { bottom = std::max(bottom, double{span.out}); });
      EXPECT_NEAR(bottom, z, 0.35) << "nothing closed over the furrow";
    }
}

// A deposit outside the model is undone. It must not change the last digit of any force, or of any
// position that clay uses.
TEST(ReshapeStroke, WhatWasUndoneLeavesNoTrace) {
  Random random;
  for (int trial = 0; trial < 40; trial++) {
    ReshapeSettings s = settings_of(Mode::press, 6);
    s.tool = random_tool(random, {2, 5, 30, 40});
    TriDexel plain = block(72, {10, 10, 10}, {50, 50, 40}),
             undone = block(72, {10, 10, 10}, {50, 50, 40});
    const Snapshot before = undone.snapshot();
    add(undone, SweptBall(LatticePoint{Vec3(40, 40, 66)}, {}, 4));
    undone.restore(before);
    const Vec3 from(random.uniform(15, 45), random.uniform(15, 45), 42);
    const std::vector<Vec3> path{from,
                                 from + Vec3(random.uniform(-4, 4), random.uniform(-4, 4), -5)};
    if (trial % 2 == 0) {
      EXPECT_EQ(stroke(plain, s, path, 8).work, stroke(undone, s, path, 8).work) << random.note();
    } else {
      const Pose start{path[0],
                       frame_from_axis(Vec3(random.in_box(-1, 1) + Vec3(0, 0, 2)).normalized())};
      DirectTool one(plain, start), other(undone, start);
      for (int k = 1; k <= 8; k++) {
        const Vec3 tip = path[0] + (path[1] - path[0]) * k / 8;
        const auto a = one.advance(s.tool, tip, Vec3::Zero(), Mode::cut, s.law, kMaterials),
                   b = other.advance(s.tool, tip, Vec3::Zero(), Mode::cut, s.law, kMaterials);
        ASSERT_TRUE(a.ok() && b.ok());
        EXPECT_EQ(a.value().wrench.force, b.value().wrench.force) << random.note();
        EXPECT_EQ(a.value().wrench.moment, b.value().wrench.moment) << random.note();
      }
    }
    EXPECT_NE(plain.content_hash(), before.content_hash()) << "the stroke does nothing";
    EXPECT_EQ(plain.content_hash(), undone.content_hash()) << trial << random.note();
  }
}

// With a small tolerance, a collar's height is computed from spans, otherwise from distances at
// nodes. The test measures the added volume by all spans of the model. Slabs extend from border to
// border of the lattice. Where their tops pass nodes, the volume has steps.
TEST(ReshapeStroke, ACollarAddsWhatItIsToAdd) {
  Random random;
  Clay clay;
  const int rounds = test::rounds_of("KIBORI_COLLARS", 120);
  double rough_added = 0, rough_wanted = 0;
  for (int round = 0; round < rounds; round++) {
    const bool slab = round % 2 == 0, rough = round % 4 < 2;
    TriDexel model(cube(48));
    Vec3 top(24, 24, random.uniform(20, 28));
    if (slab) {
      top.head<2>() = random.in_box(0, 48).head<2>();
      model.fill_block({Vec3::Zero(), Vec3(48, 48, top.z())}, 0);
    } else {
      const double radius = random.uniform(8, 30);
      const Vec3 out = (Vec3(0, 0, 2) + random.in_box(-1, 1)).normalized();
      add(model, SweptBall(LatticePoint{top - radius * out}, {}, radius));
    }
    const PressingTool at{{top + Vec3(0, 0, 1), Mat3::Identity()}, Vec3::UnitX(), top};
    const double before = model.volume_mm3(), wanted = random.uniform(4, 25);
    const auto raised = clay.raise(model, BallTool{2}, {&at, 1}, 0, 9, wanted, rough ? 1e-2 : 1e-5);
    ASSERT_TRUE(raised.ok()) << raised.error();
    const double added = model.volume_mm3() - before;
    EXPECT_NEAR(raised.value().added_mm3 - raised.value().removed_mm3, added, 1e-4);
    // Maximum errors of 5000 rounds: 0.36 at a slab's step, 0.12 by nodes next to a small ball,
    // 0.0014 by spans.
    const double largest = slab ? 0.5 : rough ? 0.2 : 0.005;
    EXPECT_NEAR(added, wanted, largest * wanted) << round << random.note();
    if (!rough) continue;
    rough_added += added;
    rough_wanted += wanted;
  }
  // Nodes give 1.4 % too much next to balls and 0.5 % next to slabs. The other errors are random.
  EXPECT_NEAR(rough_added, rough_wanted, 0.04 * rough_wanted) << random.note();
}

// After many presses, the error of the volume is below 1e-4 of the body. In about one press of a
// hundred, the fields put a tied end (dexel/volume.h) on different sides of a node. Then the model
// gains or loses a cell that no field reports.
TEST(ReshapeStroke, ClayKeepsItsVolumeOverManyStrokes) {
  Random random;
  TriDexel model = block(48, {8, 8, 8}, {40, 40, 36});
  const double before = model.volume_mm3();
  const int strokes = test::rounds_of("KIBORI_PRESSES", 150);
  for (int i = 0; i < strokes; i++) {
    ReshapeSettings s = settings_of(Mode::press, 5);
    s.tool = BallTool{random.uniform(2, 5)};
    const Vec3 from(random.uniform(14, 34), random.uniform(14, 34), random.uniform(34, 36));
    stroke(model, s, {from, from + Vec3(random.uniform(-6, 6), random.uniform(-6, 6), -1)}, 6);
  }
  EXPECT_NEAR(model.volume_mm3(), before, 1e-4 * before) << random.note();
  EXPECT_EQ(disagreeing(model), 0) << random.note();
}

// Material without room stays pending and is reported: a body that fills its lattice except for a
// gap at the top.
TEST(ReshapeStroke, ClayWithoutRoomStaysPending) {
  TriDexel model(cube(40));
  model.fill_block({Vec3::Zero(), Vec3(40, 40, 39.7)}, 0);
  const double before = model.volume_mm3();
  ReshapeSettings s = settings_of(Mode::press, 5);
  s.tool = BallTool{6};
  ReshapeStroke press(model);
  DirectTool tool(model, {{20, 20, 42}, Mat3::Identity()});
  ASSERT_TRUE(press.begin(s, kMaterials, tool.pose()).ok());
  ToolTick last;
  for (int k = 1; k <= 60; k++) {
    auto tick =
        tool.advance(s.tool, {20, 20, 42 - 0.25 * k}, Vec3::Zero(), s.mode, s.law, kMaterials);
    ASSERT_TRUE(tick.ok());
    ASSERT_TRUE(press.advance(tick.value()).ok());
    last = tick.value();
  }
  ASSERT_TRUE(press.end(last).ok());
  const double pressed = 3.14159265 * 36 * 13;  // approximately
  EXPECT_GT(press.pending_mm3(), 0.3 * pressed);
  EXPECT_NEAR(model.volume_mm3() + press.pending_mm3(), before, 1e-3 * pressed);
  EXPECT_EQ(disagreeing(model), 0);
}

// Smoothing a rough body: the volume removed from peaks returns, to 1e-3 of the moved volume.
TEST(ReshapeStroke, ASmoothingStrokeKeepsItsVolume) {
  Random random;
  const int rounds = test::rounds_of("KIBORI_SMOOTHINGS", 5);
  for (int round = 0; round < rounds; round++) {
    TriDexel model = block(64, {8, 8, 8}, {56, 56, 38.3});
    for (int i = 0; i < 40; i++)
      add(model, SweptBall(LatticePoint{{random.uniform(12, 52), random.uniform(12, 52),
                                         random.uniform(35, 39)}},
                           {}, random.uniform(2, 4)));
    const double before = model.volume_mm3();
    TriDexel plain(model.snapshot(), model.material_bounds());
    ReshapeSettings s = settings_of(Mode::smooth, 8, 0.6);
    s.brush.sigma_mm = 1.5;
    s.brush.keep_volume = true;
    const std::vector<Vec3> path{{16, 32, 39}, {48, 34, 39}};
    // Moved volume [mm^3], by the same dabs one by one.
    Reshaper reshaper;
    double moved = 0;
    for (double at = 0; at <= (path[1] - path[0]).norm(); at += 2) {
      const auto done = reshaper.dab(plain, FieldVerb::smooth, s.brush,
                                     Vec3(path[0] + at * (path[1] - path[0]).normalized()));
      ASSERT_TRUE(done.ok());
      moved += done.value().added_mm3 + done.value().removed_mm3;
    }
    EXPECT_GT(moved, 20);
    stroke(model, s, path, 40);
    // The bound includes one cell of one field, a third of a cell in volume. If a span appears or
    // disappears, the last dab can have this error. Later dabs correct the errors of earlier ones.
    EXPECT_NEAR(model.volume_mm3(), before, 1e-3 * moved + 1.0 / 3) << round << random.note();
  }
}

// Where a pen presses less, the ridge of a stroke is narrower or lower. The number of ticks does not
// matter.
TEST(ReshapeStroke, ABrushFollowsThePressure) {
  struct Ridge {
    double low_width = 0, high_width = 0, low = 0, high = 0;
  };
  const auto ridge_of = [](PressureUse use, int ticks) {
    TriDexel model = block(96, {4, 4, 4}, {92, 92, 40});
    ReshapeSettings settings = settings_of(Mode::inflate, 12, 0.5);
    settings.brush.sigma_mm = 2;
    settings.brush.pressure = use;
    ReshapeStroke reshape(model);
    DirectTool tool(model, {Vec3(16, 48, 40), Mat3::Identity()});
    EXPECT_TRUE(reshape.begin(settings, kMaterials, tool.pose()).ok());
    for (int i = 1; i <= ticks; i++) {
      const double share = static_cast<double>(i) / ticks;
      auto tick = tool.advance(settings.tool, Vec3(16 + 64 * share, 48, 40), Vec3::Zero(),
                               settings.mode, settings.law, kMaterials);
      EXPECT_TRUE(tick.ok());
      tick.value().pressure = 0.25 + 0.75 * share;
      EXPECT_TRUE(reshape.advance(tick.value()).ok());
    }
    const auto height = [&](int x, int y) {
      double top = 0;
      model.field(Axis::z).view().for_spans(
          x, y, [&](const Span& span) { top = static_cast<double>(span.out); });
      return top - 40;
    };
    Ridge ridge{0, 0, height(24, 48), height(70, 48)};
    for (int y = 4; y < 92; y++) {
      ridge.low_width += height(24, y) > 0.05 * ridge.low;
      ridge.high_width += height(70, y) > 0.05 * ridge.high;
    }
    return ridge;
  };
  const Ridge size = ridge_of(PressureUse::size, 64),
              strength = ridge_of(PressureUse::strength, 64),
              none = ridge_of(PressureUse::none, 64), both = ridge_of(PressureUse::both, 64);
  EXPECT_LT(size.low_width, 0.6 * size.high_width);
  EXPECT_NEAR(strength.low_width, strength.high_width, 2);
  EXPECT_LT(strength.low, 0.6 * strength.high);
  EXPECT_NEAR(none.low, none.high, 0.3);
  EXPECT_NEAR(none.low_width, none.high_width, 2);
  EXPECT_LT(both.low_width, 0.6 * both.high_width);
  const Ridge quick = ridge_of(PressureUse::both, 16);
  EXPECT_NEAR(quick.high, both.high, 0.05);
  EXPECT_NEAR(quick.high_width, both.high_width, 1);
}

TEST(ReshapeStroke, ACreaseSinksALineAndDrawsItTogether) {
  TriDexel model = block(64, {8, 8, 8}, {56, 56, 40});
  stroke(model, settings_of(Mode::crease, 10, 0.5), {{16, 32, 40}, {48, 32, 40}}, 30);
  const auto top = [&](int x, int y) {
    double z = 0;
    model.field(Axis::z).view().for_spans(x, y, [&](const Span& span) { z = span.out; });
    return z;
  };
  EXPECT_NEAR(top(32, 32), 38, 0.6) << "a fifth of the radius";
  EXPECT_NEAR(top(32, 45), 40, 1e-3) << "beside the brush";
  EXPECT_GT(top(32, 37), 39.5);
  EXPECT_EQ(disagreeing(model), 0);
  EXPECT_EQ(test::broken(extract_surface(model.snapshot())), "");
}

// A crease with negative strength makes a ridge of the same height.
TEST(ReshapeStroke, ANegativeCreaseRaisesALine) {
  TriDexel model = block(64, {8, 8, 8}, {56, 56, 40});
  stroke(model, settings_of(Mode::crease, 10, -0.5), {{16, 32, 40}, {48, 32, 40}}, 30);
  double top = 0, aside = 0;
  const auto view = model.field(Axis::z).view();
  view.for_spans(32, 32, [&](const Span& span) { top = span.out; });
  view.for_spans(32, 45, [&](const Span& span) { aside = span.out; });
  EXPECT_NEAR(top, 42, 0.6) << "a fifth of the radius";
  EXPECT_NEAR(aside, 40, 1e-3);
  EXPECT_EQ(disagreeing(model), 0);
  EXPECT_EQ(test::broken(extract_surface(model.snapshot())), "");
}

// Pulls a strand out of a flat top. The oracle follows points of the top. At each dab, a point
// moves by (1 - r^4)^2 times the tool's step, where r is its distance from the tool.
TEST(ReshapeStroke, ASnakeHookPullsAStrand) {
  constexpr double radius = 8, top = 16;
  const Vec3 start(32, 32, top);
  const std::vector<Vec3> path{start, start + Vec3(0, 0, 24), start + Vec3(10, 0, 38)};
  TriDexel model = block(64, {4, 4, 4}, {60, 60, top});
  stroke(model, settings_of(Mode::snake_hook, radius), path, 40);
  EXPECT_EQ(disagreeing(model), 0);
  EXPECT_EQ(test::broken(extract_surface(model.snapshot())), "");
  EXPECT_EQ(find_pieces(model.snapshot()).all().size(), 1u) << "no crumbs";
  // The dabs' places.
  std::vector<Vec3> dabs{start};
  const double first = (path[1] - path[0]).norm(), all = first + (path[2] - path[1]).norm();
  for (double s = 2; s <= all; s += 2)
    dabs.push_back(s <= first ? Vec3(start + s * Vec3::UnitZ())
                              : Vec3(path[1] + (s - first) * (path[2] - path[1]).normalized()));
  std::vector<Vec3> surface;
  for (double r = 0; r <= 12; r += 0.02)
    for (int side = 0; side < 24; side++) {
      const double angle = 2 * kPi * side / 24;
      Vec3 at = start + r * Vec3(std::cos(angle), std::sin(angle), 0);
      for (size_t i = 1; i < dabs.size(); i++) {
        const double q = (at - dabs[i - 1]).squaredNorm() / (radius * radius);
        if (q < 1) at += (1 - q * q) * (1 - q * q) * (dabs[i] - dabs[i - 1]);
      }
      surface.push_back(at);
    }
  double worst = 0, highest = 0;
  for (const Vec3& at : surface) highest = std::max(highest, at.z());
  double reached = 0;
  for_ends(model, [&](const Vec3& at, const Vec3&) {
    reached = std::max(reached, at.z());
    if ((at - start).norm() < 10 || at.z() < top + 0.5) return;
    double nearest = 64;
    for (const Vec3& point : surface) nearest = std::min(nearest, (at - point).norm());
    worst = std::max(worst, nearest);
  });
  EXPECT_NEAR(reached, highest, 0.6);
  EXPECT_LE(worst, 0.8);
  std::printf("a strand of %.1f cells, off by %.2f\n", reached - top, worst);
  // Another number of ticks gives the same result.
  TriDexel again = block(64, {4, 4, 4}, {60, 60, top});
  stroke(again, settings_of(Mode::snake_hook, radius), path, 7);
  EXPECT_NEAR(again.volume_mm3(), model.volume_mm3(), 0.5);
}

// Strength and falloff set the colour of the surface. Nothing moves, and the inside is not painted.
// The last dab is at x = 31.
TEST(ReshapeStroke, PaintColoursTheSurface) {
  TriDexel model = block(48, {8, 8, 8}, {40, 40, 30});
  const double volume = model.volume_mm3();
  ReshapeSettings s = settings_of(Mode::paint, 6);
  s.brush.color = {10, 200, 30};
  s.brush.falloff = Falloff::constant;
  const Sums sums = stroke(model, s, {{16, 24, 30}, {32, 24, 30}}, 20);
  EXPECT_EQ(model.volume_mm3(), volume);
  EXPECT_EQ(sums.max_force, 0);
  EXPECT_EQ(sums.points, 0);
  int painted = 0;
  for (const Axis axis : kAxes) {
    const FieldSnapshot& field = model.field(axis).view();
    for (int u = 0; u < 48; u++)
      for (int v = 0; v < 48; v++)
        field.for_spans(u, v, [&](const Span& span) {
          for (const bool out : {false, true}) {
            Vec3 at;
            at[u_index(axis)] = u + 0.5;
            at[v_index(axis)] = v + 0.5;
            at[depth_index(axis)] = out ? span.out : span.in;
            const Color paint = out ? span.paint_out : span.paint_in;
            const Vec3 nearest(std::clamp(at.x(), 16.0, 31.0), 24, 30);
            const double off = (at - nearest).norm();
            if (off < 5.8) {
              EXPECT_EQ(paint, 0xff1ec80au);
            }
            if (off > 6) {
              EXPECT_EQ(paint, 0u);
            }
            painted += paint != 0;
          }
        });
  }
  EXPECT_GT(painted, 200);
  // Half the strength, over the material's own colour.
  TriDexel half = block(48, {8, 8, 8}, {40, 40, 30});
  s.brush.strength = 0.5;
  stroke(half, s, {{16, 24, 30}, {16, 24, 30}}, 1);
  half.field(Axis::z).view().for_spans(16, 24, [&](const Span& span) {
    const auto color = kMaterials[0].color;
    EXPECT_NEAR(span.paint_out & 0xff, (color[0] + 10) / 2.0, 1);
    EXPECT_NEAR(span.paint_out >> 8 & 0xff, (color[1] + 200) / 2.0, 1);
  });
}

// With fourfold symmetry about z and a plane, every ray has its image, in every mode.
TEST(ReshapeStroke, ImagesDoTheSame) {
  Random random;
  const auto ends = [](const TriDexel& model) {
    std::vector<Vec3> all;
    for_ends(model, [&](const Vec3& at, const Vec3&) { all.push_back(at); });
    return all;
  };
  for (int i = static_cast<int>(Mode::smooth); i <= static_cast<int>(Mode::press); i++) {
    const Mode mode = static_cast<Mode>(i);
    TriDexel model = block(64, {8, 8, 8}, {56, 56, 40});
    ReshapeSettings s = settings_of(mode, 7, 0.7);
    s.tool = BallTool{4};
    s.symmetry = {{true, false, false}, Vec3::Constant(32), 4, Axis::z};
    s.brush.flatten_to = FlattenTo::plane;
    s.brush.plane = {{32, 32, 38}, Vec3::UnitZ()};
    const Vec3 from(random.uniform(12, 30), random.uniform(12, 20), 39);
    stroke(model, s, {from, from + Vec3(4, 2, mode == Mode::press ? -1 : 4)}, 9, 0.5);
    EXPECT_EQ(disagreeing(model), 0) << name_of(mode);
    const std::vector<Vec3> all = ends(model);
    // Volumes of the four quarters.
    std::array<double, 4> quarter{};
    for (int u = 0; u < 64; u++)
      for (int v = 0; v < 64; v++)
        model.field(Axis::z).view().for_spans(u, v, [&](const Span& span) {
          quarter[static_cast<size_t>(2 * (u < 32) + (v < 32))] += double{span.out} - span.in;
        });
    for (const double q : quarter)
      EXPECT_NEAR(q, quarter[0],
                  mode == Mode::press                   ? 10
                  : warps(mode) || mode == Mode::crease ? 3  // a crease pinches
                                                        : 0.2)
          << name_of(mode) << " " << random.note();
  }
}

// A circle on a ball with the default settings. The surface is levelled under the brush, and no
// wall rises next to it. With FlattenTo::stroke, the brush would fill up to the plane under the
// first dab, around the whole circle.
TEST(ReshapeStroke, FlattenFollowsARoundForm) {
  const Vec3 center = Vec3::Constant(32);
  constexpr double radius = 24;
  const auto highest_over_ball = [&](FlattenTo to) {
    TriDexel model(cube(64));
    add(model, tool_at(BallTool{radius}, {center - Vec3(0, 0, radius), Mat3::Identity()},
                       model.lattice()));
    ReshapeSettings s = settings_of(Mode::flatten, 4, 0.5);
    if (to != FlattenTo::dab) s.brush.flatten_to = to;
    std::vector<Vec3> circle;
    for (int i = 0; i <= 40; i++) {
      const double angle = 2 * kPi * i / 40;
      const Vec3 side(8 * std::cos(angle), 8 * std::sin(angle), 0);
      circle.push_back(center + side + Vec3(0, 0, std::sqrt(radius * radius - 64)));
    }
    stroke(model, s, circle, 4);
    EXPECT_EQ(disagreeing(model), 0);
    double highest = 0;
    for_ends(model, [&](const Vec3& at, const Vec3&) {
      highest = std::max(highest, (at - center).norm() - radius);
    });
    return highest;
  };
  EXPECT_LT(highest_over_ball(FlattenTo::dab), 0.5);
  EXPECT_GT(highest_over_ball(FlattenTo::stroke), 1.5);
}

// Trim removes material above the plane, and never adds. Build never removes, and a second pass
// adds again. Both work on a wavy top. The plane under a brush is at the middle height of the
// waves.
TEST(ReshapeStroke, TrimOnlyRemovesAndBuildOnlyAdds) {
  const auto waves = [] {
    TriDexel model = block(64, {8, 8, 8}, {56, 56, 40});
    for (int i = 0; i < 5; i++)
      add(model,
          tool_at(Capsule{4, 40}, {Vec3(12.0 + 10 * i, 12, 38), frame_from_axis(Vec3::UnitY(), 0)},
                  model.lattice()));
    return model;
  };
  const std::vector<Vec3> path{{20, 32, 41}, {44, 32, 41}};
  const TriDexel before = waves();
  for (const Mode mode : {Mode::trim, Mode::build}) {
    const double sign = mode == Mode::trim ? -1 : 1;
    TriDexel model = waves();
    const Sums sums = stroke(model, settings_of(mode, 9, 0.8), path, 60);
    EXPECT_NEAR(sums.removed, before.volume_mm3() - model.volume_mm3(), 1);
    EXPECT_GT(sign * (model.volume_mm3() - before.volume_mm3()), 50) << name_of(mode);
    EXPECT_EQ(disagreeing(model), 0);
    // No ray of any field has gained (trim) or lost (build) material.
    for (const Axis axis : kAxes)
      for (int u = 0; u < 64; u++)
        for (int v = 0; v < 64; v++) {
          double was = 0, is = 0;
          const auto sum = [](double& into) {
            return [&into](const Span& span) { into += double{span.out} - span.in; };
          };
          before.field(axis).view().for_spans(u, v, sum(was));
          model.field(axis).view().for_spans(u, v, sum(is));
          ASSERT_GE(sign * (is - was), -1e-3) << name_of(mode) << " " << u << " " << v;
        }
    const double after_one = model.volume_mm3();
    stroke(model, settings_of(mode, 9, 0.8), path, 60);
    if (mode == Mode::build) {
      EXPECT_GT(model.volume_mm3(), after_one + 50);
    }
    EXPECT_EQ(test::broken(extract_surface(model.snapshot())), "") << name_of(mode);
  }
}

// Images that coincide count once: two mirrors and a half turn are the same.
TEST(SymmetryImages, AreEachOther) {
  EXPECT_EQ(SymmetryImages(Symmetry{}).size(), 0u);
  EXPECT_EQ(SymmetryImages({{true, true, true}, {}, 1, Axis::z}).size(), 7u);
  EXPECT_EQ(SymmetryImages({{}, {}, 16, Axis::x}).size(), 15u);
  EXPECT_EQ(SymmetryImages({{true, true, false}, {}, 2, Axis::z}).size(), 3u);
  EXPECT_EQ(SymmetryImages({{true, false, false}, {}, 6, Axis::z}).size(), 11u);
  for (const SymmetryImage& image : SymmetryImages({{true, false, true}, {}, 5, Axis::y}))
    EXPECT_NEAR(image.turn.determinant(), image.mirrors ? -1 : 1, 1e-12);
  EXPECT_FALSE(check_symmetry({{}, {}, 0, Axis::z}).ok());
  EXPECT_FALSE(check_symmetry({{}, {}, kMaxFold + 1, Axis::z}).ok());
}

// Cuts about an axis: the result is the same after a fifth of a turn.
TEST(SymmetryImages, CutsGoRound) {
  TriDexel model = block(64, {4, 4, 4}, {60, 60, 60});
  DirectTool tool(model, {{50, 32, 66}, Mat3::Identity()});
  tool.set_symmetry({{}, Vec3::Constant(32), 5, Axis::z});
  ASSERT_TRUE(
      tool.advance(Flat{4, 40}, {50, 32, 50}, Vec3::Zero(), Mode::cut, {}, kMaterials).ok());
  const double hole = 3.14159265 * 16 * 10;
  EXPECT_NEAR(56.0 * 56 * 56 - model.volume_mm3(), 5 * hole, 0.02 * 5 * hole);
  for (int k = 0; k < 5; k++) {
    const double angle = 2 * 3.14159265 / 5 * k;
    int spans = 0;
    double top = 0;
    model.field(Axis::z).view().for_spans(static_cast<int>(32 + 18 * std::cos(angle)),
                                          static_cast<int>(32 + 18 * std::sin(angle)),
                                          [&](const Span& span) {
                                            spans++;
                                            top = span.out;
                                          });
    EXPECT_EQ(spans, 1);
    EXPECT_NEAR(top, 50, 1e-4);
  }
}

// On the wheel, any stroke keeps the volume of the profile up to rounding. The result is the same
// from all sides, to float32.
TEST(ReshapeStroke, AThrownPotIsRoundAndKeepsItsVolume) {
  for (const Mode mode : {Mode::throw_clay, Mode::turn}) {
    TriDexel model(cube(96));
    add(model, test::tool_at(Flat{24, 50}, {{48, 48, 10}, Mat3::Identity()}, model.lattice()));
    const double before = model.volume_mm3();
    ReshapeSettings s = settings_of(mode, 5);
    s.tool = BallTool{6};
    // A waist from outside, then a hollow from above.
    Sums sums = stroke(model, s, {{84, 48, 30}, {68, 48, 30}, {68, 48, 34}}, 30);
    EXPECT_GT(sums.max_force, 0);
    EXPECT_GT(sums.work, 0);
    const Sums more = stroke(model, s, {{48, 48, 66}, {48, 48, 36}, {52, 48, 40}}, 30);
    EXPECT_EQ(disagreeing(model), 0) << name_of(mode);
    EXPECT_EQ(test::broken(extract_surface(model.snapshot())), "") << name_of(mode);
    if (mode == Mode::throw_clay) {
      EXPECT_NEAR(model.volume_mm3(), before, 2e-3 * before);
    } else {
      EXPECT_LT(model.volume_mm3(), before - 2000);
    }
    EXPECT_NEAR(sums.removed + more.removed, before - model.volume_mm3(), 0.1);
    // Every ray, and those that are a quarter of a turn away, or mirrored.
    int64_t unlike = 0;
    for (int v = 0; v < 96; v++)
      for (int u = 0; u < 96; u++) {
        std::vector<float> x, y;
        model.field(Axis::x).view().for_spans(u, v, [&](const Span& span) {
          x.push_back(span.in);
          x.push_back(span.out);
        });
        model.field(Axis::y).view().for_spans(v, u, [&](const Span& span) {
          y.push_back(span.in);
          y.push_back(span.out);
        });
        unlike += x != y;
        for (size_t i = 0; i < x.size(); i++) EXPECT_NEAR(x[i], 96 - x[x.size() - 1 - i], 1e-5);
      }
    EXPECT_EQ(unlike, 0);
  }
}

// The volume of the profile is kept up to rounding. The volume of the model is less exact, because
// rays only approximate a round body.
TEST(Wheel, ManyPassesKeepTheVolume) {
  Random random;
  TriDexel model(cube(48));
  add(model, test::tool_at(Flat{12, 30}, {{24, 24, 8}, Mat3::Identity()}, model.lattice()));
  const int passes = test::rounds_of("KIBORI_PASSES", 2000);
  Wheel wheel(model);
  wheel.begin(Vec3::Constant(24), BallTool{3}, {{44, 24, 20}, Mat3::Identity()});
  const double before = wheel.profile().volume();
  EXPECT_NEAR(before, 3.14159265 * 144 * 30, 1);
  for (int i = 0; i < passes; i++) {
    const double z = random.uniform(8, 32);
    const auto turned = wheel.advance(WheelVerb::throw_clay, BallTool{3},
                                      {{random.uniform(40, 43), 24, z}, Mat3::Identity()},
                                      {random.uniform(-2.5, 0), 0, 0});
    ASSERT_TRUE(turned.ok());
  }
  EXPECT_NEAR(wheel.profile().volume(), before, 1e-9 * before) << random.note();
  EXPECT_NEAR(model.volume_mm3(), before, 5e-3 * before) << random.note();
  EXPECT_EQ(disagreeing(model), 0) << random.note();
  // Written and read again, it is the same to float32.
  const WheelProfile again = read_profile(model, LatticePoint{Vec3::Constant(24)});
  EXPECT_NEAR(again.volume(), before, 1e-6 * before) << random.note();
  // The same after a quarter of a turn and in a mirror: the ends of the other field's ray, and of
  // the adjacent rays. Along z, to the bit.
  const auto ends = [&](Axis axis, int u, int v) {
    std::vector<float> all;
    model.field(axis).view().for_spans(u, v, [&](const Span& span) {
      all.push_back(span.in);
      all.push_back(span.out);
    });
    return all;
  };
  int unlike = 0;
  for (int i = 0; i < 48; i++)
    for (int k = 0; k < 48; k++) {
      const std::vector<float> x = ends(Axis::x, i, k), z = ends(Axis::z, i, k);
      unlike += x != ends(Axis::y, k, i) || x != ends(Axis::x, 47 - i, k);
      unlike += z != ends(Axis::z, k, i) || z != ends(Axis::z, 47 - i, k);
      for (size_t e = 0; e < x.size(); e++)
        EXPECT_NEAR(x[e], 48 - x[x.size() - 1 - e], 4e-6) << random.note();
    }
  EXPECT_EQ(unlike, 0) << random.note();
}

// The surface passes through nodes, or misses them by less than rounding. Rays that only touch the
// body there have no span in one field, and no node in another. Found by random mixtures, seeds
// 1264179438 and 1264180449.
TEST(Wheel, RadiiThatPassNodesLeaveTheFieldsAgreeing) {
  for (const double off : {0.0, 1e-16, -1e-16, 1e-12, -1e-12, 1e-8, -1e-8, 9e-7, 1.1e-6, 1e-4})
    for (const double hollow : {0.0, 1.0, 4.0})
      for (const double outer : {4.0, 5.0, 9.0, 25.0}) {
        if (hollow >= outer) continue;
        WheelProfile profile;
        profile.centre = {5.5, 5.5, 0};  // over nodes
        profile.first = 2;
        profile.low = 2.2;
        profile.high = 8.3;
        // A foot, so that curves also pass between rows.
        for (const double radius2 : {25.0, outer, outer, 16.0, outer, 25.0}) {
          profile.outer.push_back(radius2 + off);
          profile.hollow.push_back(std::max(0.0, hollow + off));
        }
        TriDexel model(cube(11));
        add(model, WheelSolid(profile));
        EXPECT_EQ(disagreeing(model), 0) << outer << " " << hollow << " " << off;
        EXPECT_EQ(test::broken(extract_surface(model.snapshot())), "");
      }
}

// Two fingers: the wall between them becomes as thick as their distance, from either side.
TEST(Wheel, TwoFingersHoldTheWall) {
  for (const bool within : {false, true}) {
    TriDexel model(cube(100));
    for (const bool hollow : {false, true}) {
      const SweptTool tube(Flat{hollow ? 16.0 : 30.0, hollow ? 60.0 : 50.0},
                           Pose{Vec3(50, 50, hollow ? 25 : 15), Mat3::Identity()}, Vec3::Zero(),
                           model.lattice());
      Removed removed;
      if (hollow)
        cut(model, tube.solid(), {}, removed);
      else
        deposit(model, tube.solid(), 0, {}, removed);
    }
    Wheel wheel(model);
    const Tool finger = BallTool{4};
    Pose at{Vec3(within ? 60 : 90, 50, 40), Mat3::Identity()};
    wheel.begin(Vec3(50, 50, 0), finger, at);
    const double volume = wheel.profile().volume();
    ASSERT_NEAR(volume, kPi * (900.0 * 50 - 256 * 40), 0.01 * volume);
    // Up to the wall, two cells into it, then upwards.
    double pressed = 0;
    for (const Vec3& to : {Vec3(within ? 64 : 82, 50, 40), Vec3(within ? 64 : 82, 50, 52)}) {
      const Vec3 path = to - at.tip;
      const auto done = wheel.advance(WheelVerb::throw_clay, finger, at, path, 6);
      ASSERT_TRUE(done) << done.error();
      pressed += done.value().pressed_mm3;
      at.tip = to;
    }
    EXPECT_GT(pressed, 0);
    const WheelProfile& p = wheel.profile();
    EXPECT_NEAR(p.volume(), volume, 1e-9 * volume);
    EXPECT_NEAR(model.volume_mm3(), volume, 1e-3 * volume);
    // The ball's widest part moved from z = 44 to 56. Its tip is its lowest point.
    for (size_t k = 0; k < p.outer.size(); k++)
      if (p.row_z(k) > 44 && p.row_z(k) < 55) {
        const double wall = std::sqrt(p.outer[k]) - std::sqrt(p.hollow[k]);
        // A wall that is pressed outwards gets thinner, because its circumference grows.
        EXPECT_NEAR(wall, within ? 5.85 : 6, within ? 0.2 : 0.05) << p.row_z(k);
        EXPECT_NEAR(std::sqrt(within ? p.hollow[k] : p.outer[k]), within ? 18 : 28, 0.05);
      }
    // The displaced material is above and below the path. There the outer radius exceeds 30.
    EXPECT_GT(p.outer[static_cast<size_t>(63.5 - p.first)], 900);
  }
}

// A lump that is not rotationally symmetric is centred, and keeps its volume.
TEST(Wheel, CentresALump) {
  TriDexel model = block(64, {14, 20, 8}, {40, 42, 30});
  const double before = model.volume_mm3();
  Wheel wheel(model);
  wheel.begin(Vec3::Constant(32), BallTool{3}, {{60, 32, 20}, Mat3::Identity()});
  EXPECT_NEAR(wheel.profile().volume(), before, 1e-9 * before);
  EXPECT_NEAR(wheel.profile().outer[5], 26 * 22 / 3.14159265, 1);
  EXPECT_TRUE(
      wheel.advance(WheelVerb::turn, BallTool{3}, {{48, 32, 20}, Mat3::Identity()}, {-4, 0, 0})
          .ok());
  EXPECT_EQ(disagreeing(model), 0);
  TriDexel none(cube(8));
  Wheel empty(none);
  empty.begin(Vec3::Constant(4), BallTool{3}, {});
  EXPECT_TRUE(empty.advance(WheelVerb::turn, BallTool{3}, {}, {1, 0, 0}).ok());
}

}  // namespace
}  // namespace kibori::reshape_stroke_tests
