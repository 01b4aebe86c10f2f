// SPDX-License-Identifier: MIT
// Protected regions: nothing cuts them (against arithmetic on intervals), and they stop a tool as a
// wall (against closed forms).
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/run/carving.h>
#include <kibori/body/bodies.h>
#include <kibori/body/workbench.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/spring_tool.h>
#include <kibori/surface/surface.h>

#include "tests/every_tool.h"
#include "tests/reshape_support.h"
#include "tests/support.h"
#include "tests/surface_check.h"

namespace kibori::no_go_tests {
namespace {

using test::Random;

using Intervals = std::vector<std::pair<float, float>>;

Intervals on_ray(const Snapshot& model, Axis axis, int u, int v) {
  Intervals list;
  model.field(axis).for_spans(u, v, [&](const Span& s) { list.emplace_back(s.in, s.out); });
  return list;
}
// Sorted; touching intervals are merged.
Intervals merged(Intervals list) {
  std::sort(list.begin(), list.end());
  Intervals out;
  for (const auto& [in, to] : list)
    if (!out.empty() && in <= out.back().second)
      out.back().second = std::max(out.back().second, to);
    else
      out.emplace_back(in, to);
  return out;
}
Intervals both(const Intervals& a, const Intervals& b) {
  Intervals out;
  for (const auto& [p, q] : a)
    for (const auto& [r, s] : b)
      if (std::max(p, r) < std::min(q, s)) out.emplace_back(std::max(p, r), std::min(q, s));
  return merged(out);
}

// True if their ends are equal within rounding. Ignores slivers of that size.
bool alike(const Intervals& a, const Intervals& b) {
  constexpr float kRounding = 2e-4f;
  const auto solid = [](const Intervals& list) {
    Intervals out;
    for (const auto& [in, to] : list)
      if (!out.empty() && in <= out.back().second + kRounding)
        out.back().second = to;
      else
        out.emplace_back(in, to);
    std::erase_if(out, [](const auto& span) { return span.second - span.first <= kRounding; });
    return out;
  };
  const Intervals p = solid(a), q = solid(b);
  return std::equal(p.begin(), p.end(), q.begin(), q.end(), [](const auto& s, const auto& t) {
    return std::abs(s.first - t.first) <= kRounding && std::abs(s.second - t.second) <= kRounding;
  });
}

Tool any_tool(Random& random) { return test::random_tool(random, {0.4, 6, 5, 15}); }

TEST(NoGo, RandomStrokesNeverCutIntoIt) {
  Random random;
  SCOPED_TRACE(random.note());
  // Under a sanitiser, which uses no wide vectors, 10000 strokes take minutes.
  const int strokes =
      test::rounds_of("KIBORI_NO_GO_STROKES", std::getenv("KIBORI_SHORT") ? 1500 : 10000);
  Lattice lattice = test::cube(32);
  lattice.nodes = Index3(32, 27, 21);
  const std::vector<Material> materials(2);
  std::unique_ptr<TriDexel> model, twin;
  std::unique_ptr<NoGo> no_go;
  Snapshot was;
  int cut_without = 0;
  for (int i = 0; i < strokes; i++) {
    if (i % 10 == 0) {
      model = std::make_unique<TriDexel>(lattice);
      model->fill_block({Vec3(1.5, 2.25, 2), Vec3(30, 24, 19)}, 0);
      auto kept = std::make_unique<TriDexel>(lattice);
      for (int n = random.integer(1, 4); n > 0; n--)
        test::add(*kept, test::tool_at(any_tool(random),
                                       {random.in_box(2, 24), frame_from_axis(random.direction())},
                                       lattice));
      no_go = std::make_unique<NoGo>(std::move(kept));
      was = model->snapshot();
      twin = std::make_unique<TriDexel>(was, model->material_bounds());
    }
    const Tool tool = any_tool(random);
    const Pose start{random.in_box(-2, 28), frame_from_axis(random.direction())};
    Symmetry symmetry;
    if (random.integer(0, 3) == 0) {
      symmetry.planes[static_cast<size_t>(random.integer(0, 2))] = true;
      symmetry.centre_mm = Vec3(16, 13.5, 10.5);
    }
    DirectTool guarded(*model, start), free(*twin, start);
    guarded.set_no_go(no_go.get());
    for (DirectTool* const stroke : {&guarded, &free}) stroke->set_symmetry(symmetry);
    double less = 0;
    for (int t = random.integer(1, 3); t > 0; t--) {
      const Vec3 to = guarded.pose().tip + 4 * random.direction();
      const Vec3 turn = random.integer(0, 2) ? Vec3(Vec3::Zero()) : Vec3(0.1 * random.direction());
      const auto a = guarded.advance(tool, to, turn, Mode::cut, {}, materials);
      const auto b = free.advance(tool, to, turn, Mode::cut, {}, materials);
      ASSERT_TRUE(a.ok() && b.ok());
      less += b.value().removed_mm3 - a.value().removed_mm3;
    }
    cut_without += less > 1e-6;
    if (i % 5 != 4 && i + 1 != strokes) continue;
    const Snapshot now = model->snapshot(), without = twin->snapshot(),
                   kept = no_go->model().snapshot();
    int wrong = 0;
    for (const Axis axis : kAxes)
      for (int v = 0; v < now.field(axis).v_end(); v++)
        for (int u = 0; u < now.field(axis).u_end(); u++) {
          const Intervals stays = both(on_ray(was, axis, u, v), on_ray(kept, axis, u, v));
          Intervals all = on_ray(without, axis, u, v);
          all.insert(all.end(), stays.begin(), stays.end());
          const Intervals is = merged(on_ray(now, axis, u, v));
          // Equal to the bit in the protected region. Elsewhere equal to a cut without it, except
          // for rounding.
          wrong += both(is, stays) != stays || !alike(is, merged(all));
        }
    ASSERT_EQ(wrong, 0) << i;
    ASSERT_EQ(test::disagreeing(*model), 0) << i;
    if (i % 50 == 4) {
      ASSERT_EQ(test::broken(extract_surface(now)), "") << i;
    }
  }
  EXPECT_GT(cut_without, strokes / 20);
}

// Stock around a protected region: a block's lower half, or a ball.
struct Bench {
  explicit Bench(const Tool& kept, const Vec3& at)
      : model(make_lattice(Vec3(40, 30, 20), 0.25, 10).value()) {
    model.fill_block({Vec3::Zero(), Vec3(40, 30, 20)}, 0);
    auto held = std::make_unique<TriDexel>(model.lattice());
    test::add(*held, test::tool_at(kept, {at, Mat3::Identity()}, model.lattice()));
    no_go = std::make_unique<NoGo>(std::move(held));
    materials[0].yield_n = 0.3;
    materials[0].u = 0.02;
    materials[0].c = 0;
  }
  TriDexel model;
  std::unique_ptr<NoGo> no_go;
  std::vector<Material> materials = std::vector<Material>(1);
};
Pose upright(const Vec3& tip) { return {tip, Mat3::Identity()}; }

// The hand moves down through the wood, into the wall, and back. The spring shows the distance
// between hand and tool. The force does not jump in any tick.
TEST(NoGo, PushesBackContinuously) {
  for (const Tool& shape : {Tool(BallTool{4}), Tool(Finger{0.2, 15}), Tool(Flat{3, 15})}) {
    Bench bench(BoxTool{Vec3(60, 60, 30)}, {20, 15, -20});  // up to z = 10
    const SeriesSpring spring{1.5, 0, 0.2, 0.001};
    SpringTool tool(bench.model, upright({20, 15, 21}), spring);
    tool.set_no_go(bench.no_go.get());
    const double step = 0.005;
    double last = 0, largest = 0, leap = 0, lowest = 99;
    for (int i = 0; i < 6000; i++) {
      const double z = i < 3000 ? 21 - step * i : 6 + step * (i - 3000);
      const auto result = tool.advance(shape, upright({20, 15, z}), Mode::cut, bench.materials);
      ASSERT_TRUE(result.ok());
      const double force = result.value().wrench.force.z();
      leap = std::max(leap, std::abs(force - last));
      largest = std::max(largest, force);
      last = force;
      lowest = std::min(lowest, tool.pose().tip.z());
      // The force of the spring at the wall. On the tool's way down, the wood adds to it.
      EXPECT_GT(force, spring.stiffness_n_mm * (10 - z) - 0.05) << z;
      if (i >= 3000 && z < 9.5) {
        EXPECT_NEAR(force, spring.stiffness_n_mm * (10 - z), 0.05 * spring.stiffness_n_mm);
      }
    }
    EXPECT_NEAR(lowest, 10, 0.03);
    EXPECT_NEAR(largest, spring.stiffness_n_mm * 4, 0.1);
    // Where it passes a plane of nodes in the wood, the tool may move twice as far as the hand.
    EXPECT_LE(leap, 2 * spring.stiffness_n_mm * step);
    EXPECT_EQ(last, 0);
  }
}

// A hand that pushes sideways moves the tool along the protected region and exposes it.
TEST(NoGo, IsSlidAlong) {
  const double radius = 8;
  const Vec3 centre(20, 15, 10);
  Bench bench(BallTool{radius}, centre - Vec3(0, 0, radius));
  for (const SeriesSpring& spring : {SeriesSpring{1.5, 0, 0, 0.001}, spring_of_hand(40)}) {
    TriDexel model(bench.model.snapshot(), bench.model.material_bounds());
    const double r = 2;
    SpringTool tool(model, upright({20, 15, 21}), spring);
    tool.set_no_go(bench.no_go.get());
    Vec3 last = Vec3::Zero();
    double leap = 0, largest = 0, deepest = 99, farthest = 0;
    for (int i = 0; i < 4000; i++) {
      // Down to 1.5 mm within it, and then along it.
      const double away_then = 13 - 4.5 * std::min(1.0, i / 1000.0),
                   angle = 0.8 * std::max(0, i - 1000) / 3000.0;
      const Vec3 to =
          centre - Vec3(0, 0, r) +
          away_then * Vec3(0.8 * std::sin(angle), 0.6 * std::sin(angle), std::cos(angle));
      const auto result = tool.advance(BallTool{r}, upright(to), Mode::cut, bench.materials);
      ASSERT_TRUE(result.ok());
      const Vec3 force = result.value().wrench.force;
      leap = std::max(leap, Vec3(force - last).norm());
      largest = std::max(largest, force.norm());
      last = force;
      const double away = Vec3(tool.pose().tip + Vec3(0, 0, r) - centre).norm();
      deepest = std::min(deepest, away);
      if (i > 1100) farthest = std::max(farthest, away);
    }
    EXPECT_GT(deepest, radius + r - 0.1);
    EXPECT_LT(farthest, radius + r + 0.3);
    EXPECT_LE(leap, 0.05 * largest);
    EXPECT_LT(model.volume_mm3(), 40 * 30 * 20 - 30);
    const Snapshot now = model.snapshot(), kept = bench.no_go->model().snapshot();
    for (int v = 0; v < now.field(Axis::z).v_end(); v++)
      for (int u = 0; u < now.field(Axis::z).u_end(); u++) {
        const Intervals held = on_ray(kept, Axis::z, u, v);
        ASSERT_EQ(both(on_ray(now, Axis::z, u, v), held), held);
      }
  }
}

TEST(NoGo, ProtectedBodiesAreAtTheirPoses) {
  TriDexel model(make_lattice(Vec3(20, 20, 20), 0.5, 2).value());
  model.fill_block({Vec3::Zero(), Vec3(20, 20, 20)}, 0);
  BodyList bodies = BodyList::of(model);
  EXPECT_EQ(no_go_of(bodies, 1).value(), nullptr);
  BodyAdd add;
  add.tool = BallTool{5};
  add.pose.tip = Vec3(10, 10, 5);
  add.properties.name = "template";
  add.properties.no_go = true;
  ASSERT_TRUE(apply(bodies, {{}, add}).ok());
  ASSERT_EQ(bodies.all.size(), 2u);
  const BodyId id = bodies.all[1].id;
  const double ball = 4.0 / 3 * 3.14159265358979 * 125;
  auto kept = no_go_of(bodies, 1).value();
  ASSERT_NE(kept, nullptr);
  EXPECT_NEAR(kept->model().volume_mm3(), ball, 0.01 * ball);
  // A body is not protected from its own strokes. If a protected body moves, the region moves.
  EXPECT_EQ(no_go_of(bodies, id).value(), nullptr);
  const BodyMove move{{Vec3(3, 0, 0), rotation(Vec3(0, 0, 0.1))}};
  ASSERT_TRUE(apply(bodies, {{id}, move}).ok());
  kept = no_go_of(bodies, 1).value();
  EXPECT_NEAR(kept->model().volume_mm3(), ball, 0.01 * ball);
  const Vec3 centre = rotation(Vec3(0, 0, 0.1)) * Vec3(10, 10, 10) + Vec3(3, 0, 0);
  const Lattice& lattice = kept->model().lattice();
  const Vec3 middle =
      lattice.origin_mm + lattice.pitch_mm * kept->model().material_bounds().centre().units;
  EXPECT_LT(Vec3(middle - centre).norm(), 1);
  // A protected body cannot be cut, mirrored or separated. It can be subtracted from another body.
  const CutPlane plane{centre, Vec3::UnitX()};
  for (const BodyVerb& verb :
       {BodyVerb(BodyCut{{plane}}), BodyVerb(BodyMirror{plane}), BodyVerb(BodySeparate{})}) {
    const auto done = apply(bodies, {{id}, verb});
    ASSERT_FALSE(done.ok());
    EXPECT_NE(done.error().find("protected"), std::string::npos);
  }
  EXPECT_TRUE(apply(bodies, {{1, id}, BodySubtract{}}).ok());
}

// A bridge to a knob is cut through. The knob falls off, unless it contains part of a template.
TEST(NoGo, WhatHoldsATemplateDoesNotFallAway) {
  for (const bool templated : {false, true})
    for (const Crumbs rule : {Crumbs::sort, Crumbs::fall, Crumbs::body}) {
      TriDexel model(make_lattice(Vec3(40, 20, 20), 0.5, 4).value());
      model.fill_block({Vec3::Zero(), Vec3(40, 20, 20)}, 0);
      Workbench bench(model);
      if (templated) {
        BodyAdd add;
        add.tool = BallTool{2};
        add.pose.tip = Vec3(37, 10, 8);
        add.properties.no_go = true;
        ASSERT_TRUE(bench.act({{}, add}).ok());
      }
      const auto no_go = bench.no_go();
      ASSERT_TRUE(no_go.ok());
      const Snapshot before = model.snapshot();
      DirectTool saw(model, {Vec3(33, -5, -2), Mat3::Identity()});
      saw.set_no_go(no_go.value());
      ASSERT_TRUE(saw.advance(Flat{1, 30}, Vec3(33, 25, -2), Vec3::Zero(), Mode::cut,
                              {ForceModel::energy}, {Material{}})
                      .ok());
      const double cut = model.volume_mm3();
      const CrumbResult crumbs = bench.end_stroke(before, rule);
      EXPECT_EQ(crumbs.fallen + static_cast<int>(crumbs.portions.size()), templated ? 0 : 1);
      EXPECT_EQ(model.volume_mm3() == cut, templated);
    }
}

// The volume that a ball reaches along a path is masked. Nothing cuts it until the mask is removed
// there.
TEST(NoGo, AMaskThatIsPainted) {
  TriDexel model(make_lattice(Vec3(40, 20, 20), 0.5, 4).value());
  model.fill_block({Vec3::Zero(), Vec3(40, 20, 20)}, 0);
  Workbench bench(model);
  BodyProtect paint{BallTool{3}, {Vec3(10, 10, 17), Vec3(20, 10, 17), Vec3(20, 16, 17)}};
  const auto act = [&](std::vector<BodyId> bodies) {
    return bench.act({std::move(bodies), paint});
  };
  const auto done = act({1});
  ASSERT_TRUE(done.ok()) << done.error();
  ASSERT_EQ(done.value().made, std::vector<BodyId>{2});
  EXPECT_EQ(act({1}).ok(), true);  // another mask, as none was named
  ASSERT_TRUE(bench.act({{3}, BodyRemove{}}).ok());
  const Body mask = *bench.bodies().find(2);
  EXPECT_TRUE(mask.no_go);
  // The mask consists of two half capsules that overlap. Its volume is computed by sampling.
  int64_t inside = 0;
  const double step = 0.1;
  for (double x = 5 + step / 2; x < 25; x += step)
    for (double y = 5 + step / 2; y < 20; y += step)
      for (double z = 15 + step / 2; z < 20; z += step) {
        const auto near = [&](const Vec3& a, const Vec3& b) {
          const Vec3 p(x, y, z), ab = b - a;
          const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
          return (p - a - t * ab).squaredNorm() < 9;
        };
        inside +=
            near(Vec3(10, 10, 20), Vec3(20, 10, 20)) || near(Vec3(20, 10, 20), Vec3(20, 16, 20));
      }
  const double sampled = static_cast<double>(inside) * step * step * step;
  EXPECT_NEAR(mask.model.volume_mm3(), sampled, 0.005 * sampled);

  const auto no_go = bench.no_go();
  ASSERT_TRUE(no_go.ok() && no_go.value());
  DirectTool mill(model, {Vec3(-5, 10, 16), Mat3::Identity()});
  mill.set_no_go(no_go.value());
  ASSERT_TRUE(mill.advance(Flat{8, 30}, Vec3(45, 10, 16), Vec3::Zero(), Mode::cut,
                           {ForceModel::energy}, {Material{}})
                  .ok());
  TriDexel held(model.snapshot(), model.material_bounds());
  Removed changed;
  intersect(held, DexelSolid(mask.model, mask.material_bounds), {}, changed);
  EXPECT_NEAR(held.volume_mm3(), mask.model.volume_mm3(), 1e-9);

  paint.path_mm = {Vec3(10, 10, 17), Vec3(15, 10, 17)};
  EXPECT_FALSE(act({1, 2}).ok());  // it is already protected
  paint.operation = SplineOperation::cut;
  ASSERT_TRUE(act({1, 2}).ok());
  EXPECT_LT(bench.bodies().find(2)->model.volume_mm3(), 0.7 * mask.model.volume_mm3());
  EXPECT_FALSE(act({1, 2}).ok());  // nothing is left there
  paint.path_mm = {Vec3(0, 10, 17), Vec3(30, 10, 17), Vec3(20, 10, 17), Vec3(20, 25, 17)};
  ASSERT_TRUE(act({1, 2}).ok());
  EXPECT_EQ(bench.bodies().all.size(), 1u);
  const auto free = bench.no_go();
  EXPECT_TRUE(free.ok() && !free.value());
  const auto wrong = [&](std::vector<BodyId> bodies, const auto& change) {
    BodyProtect bad = paint;
    bad.operation = SplineOperation::deposit;
    change(bad);
    return bench.act({std::move(bodies), bad}).ok();
  };
  EXPECT_FALSE(wrong({1}, [](BodyProtect& a) { a.path_mm.clear(); }));
  EXPECT_FALSE(wrong({1, 9}, [](BodyProtect&) {}));
  EXPECT_FALSE(wrong({1}, [](BodyProtect& a) { a.operation = SplineOperation::cut; }));
  EXPECT_FALSE(wrong({1}, [](BodyProtect& a) { a.path_mm = {Vec3(0, 0, 400)}; }));
  EXPECT_FALSE(wrong({1}, [](BodyProtect& a) { a.path_mm = {Vec3(0, 0, std::nan(""))}; }));
}

// A body that is moved, turned and mirrored keeps its mask in place. A mask can also move alone.
TEST(NoGo, AMaskMovesWithItsBody) {
  TriDexel model(make_lattice(Vec3(40, 20, 20), 0.5, 12).value());
  model.fill_block({Vec3::Zero(), Vec3(40, 20, 20)}, 0);
  Workbench bench(model);
  BodyProtect paint{BallTool{3}, {Vec3(10, 10, 17)}};
  ASSERT_TRUE(bench.act({{1}, paint}).ok());
  const auto alone = bench.no_go();
  ASSERT_TRUE(alone.ok() && alone.value());
  const uint64_t held = alone.value()->model().content_hash();
  const auto act = [&](std::vector<BodyId> bodies, const BodyVerb& verb) {
    const auto done = bench.act({std::move(bodies), verb});
    EXPECT_TRUE(done.ok()) << done.error();
  };
  const auto mask = [&]() -> const Body& { return *bench.bodies().find(2); };
  const auto own = [&]() -> const Body& { return *bench.bodies().find(1); };
  // In the body's frame, it has not moved, to the bit.
  act({1}, BodyMove{{Vec3(3, -2, 5), rotation(Vec3(0.3, -0.2, 0.5))}});
  EXPECT_EQ(mask().pose.tip, own().pose.tip);
  const auto moved = bench.no_go();
  ASSERT_TRUE(moved.ok() && moved.value());
  EXPECT_EQ(moved.value()->model().content_hash(), held);
  // After baking, both have the world's frame, and the mask is still within the body.
  act({1}, BodyBake{});
  EXPECT_TRUE(mask().pose.tip.isZero() && own().pose.tip.isZero());
  TriDexel within(mask().model, mask().material_bounds);
  const double volume = within.volume_mm3();
  Removed changed;
  intersect(within, DexelSolid(own().model, own().material_bounds), {}, changed);
  EXPECT_NEAR(within.volume_mm3(), volume, 1e-3 * volume);
  act({1}, BodyMove{});
  act({1}, BodyMirror{{Vec3(20, 10, 10), Vec3::UnitX()}});
  TriDexel mirrored(mask().model, mask().material_bounds);
  intersect(mirrored, DexelSolid(own().model, own().material_bounds), {}, changed);
  EXPECT_NEAR(mirrored.volume_mm3(), volume, 0.01 * volume);
  // An action on the mask alone moves only the mask. If the mask does not follow, it stays when its
  // body moves.
  act({2}, BodyMove{{Vec3(1, 0, 0), Mat3::Identity()}});
  EXPECT_EQ(own().pose.tip, Vec3(Vec3::Zero()));
  act({1}, BodyMove{{Vec3(0, 4, 0), Mat3::Identity()}});
  EXPECT_EQ(mask().pose.tip, Vec3(1, 4, 0));
  // A copy of a mask is not a mask. A locked mask blocks its body.
  act({2}, BodyDuplicate{});
  EXPECT_EQ(bench.bodies().find(3)->mask_of, 0);
  act({3}, BodyRemove{});
  BodySet lock;
  lock.properties.locked = true;
  ASSERT_TRUE(bench.act({{2}, lock}).ok());
  EXPECT_FALSE(bench.act({{1}, BodyMove{}}).ok());
  lock.properties.locked = false;
  ASSERT_TRUE(bench.act({{2}, lock}).ok());
  paint.follows = false;
  paint.path_mm = {bench.bodies().find(1)->pose.to_world(Vec3(20, 10, 10))};
  ASSERT_TRUE(bench.act({{1}, paint}).ok());
  act({1}, BodyMove{{Vec3(0, 8, 0), Mat3::Identity()}});
  EXPECT_EQ(bench.bodies().find(4)->pose.tip, Vec3(0, 4, 0));
}

// A protected body without nodes cannot be converted to another lattice, so it protects nothing.
TEST(NoGo, ACrumbThatHoldsNothingIsNoWall) {
  TriDexel model(make_lattice(Vec3(20, 20, 20), 1, 4).value());
  model.fill_block({Vec3::Zero(), Vec3(20, 20, 20)}, 0);
  BodyList bodies = BodyList::of(model);
  TriDexel thin(model.lattice());
  // On a ray along y, between two nodes.
  test::add(thin, test::tool_at(BoxTool{Vec3(0.2, 0.6, 0.2)},
                                {Vec3(10.5, 10, 10.4), Mat3::Identity()}, model.lattice()));
  ASSERT_GT(thin.volume_mm3(), 0);
  Body crumb;
  crumb.id = bodies.next++;
  crumb.no_go = true;
  crumb.model = thin.snapshot();
  crumb.material_bounds = thin.material_bounds();
  crumb.pose = {Vec3(0.3, 0.3, 0.3), rotation(Vec3(0.1, 0.2, 0))};
  bodies.all.push_back(crumb);
  const auto no_go = no_go_of(bodies, 1);
  ASSERT_TRUE(no_go.ok()) << no_go.error();
  EXPECT_EQ(apply(bodies, {{crumb.id}, BodyBake{}}).error(),
            "body 'Body 1': there is no material left");
}

// A mask in a scene: the protected part is as high as the stock was.
TEST(NoGo, AMaskInAScene) {
  const std::string text = R"([stock]
block = [40, 20, 20]
pitch = 0.5
[tool]
shape = "flat"
radius = 8
length = 20
[[no_go]]
tool = { shape = "ball", radius = 3 }
way = [[10, 10, 17], [20, 10, 17]]
[[move]]
to = [-10, 10, 16]
[[move]]
to = [50, 10, 16]
speed = 60
)";
  const auto scene = parse_scene(text, "mask.toml", ".");
  ASSERT_TRUE(scene) << scene.error();
  const auto carving = carve(scene.value(), {});
  ASSERT_TRUE(carving) << carving.error();
  const BodyList& bodies = carving.value().bodies;
  ASSERT_EQ(bodies.all.size(), 2u);
  EXPECT_EQ(bodies.all[1].name, "Mask");
  TriDexel held(bodies.all[0].model, bodies.all[0].material_bounds);
  Removed changed;
  intersect(held, DexelSolid(bodies.all[1].model, bodies.all[1].material_bounds), {}, changed);
  EXPECT_NEAR(held.volume_mm3(), bodies.all[1].model.volume_mm3(), 1e-9);
  std::string both = text;
  both.insert(both.find("way = "), "place = [1, 2, 3]\n");
  EXPECT_FALSE(parse_scene(both, "mask.toml", "."));
}

}  // namespace
}  // namespace kibori::no_go_tests
