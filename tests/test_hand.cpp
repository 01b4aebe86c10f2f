// SPDX-License-Identifier: MIT
// A pointer as the hand: the cuts that its strength permits in each wood, against closed forms. The
// result depends only on the pointer's path.
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/devices/pointer_device.h>
#include <kibori/haptics/materials.h>
#include <kibori/live/live_carving.h>
#include <kibori/motion/stroke_guide.h>

#include "tests/support.h"

namespace kibori::hand_tests {
namespace {

using test::Random;

constexpr double kPi = 3.14159265358979;
constexpr double kU = 25;  // of the material without grain

// A block of 80 x 40 x 20 mm and a pointer over it; the test runs the ticks.
struct Bench {
  PointerDevice* pointer = nullptr;
  std::unique_ptr<LiveCarving> live;
  Wrench computed;
  double removed_mm3 = 0;
  bool inside = false;
  uint32_t stroke = 0;

  // `grained`: the built-in material. Otherwise, a material with only kU.
  explicit Bench(const char* wood, const Tool& tool, bool powered, double strength_n = 200,
                 double pitch = 0.25, bool grained = true) {
    auto model = std::make_unique<TriDexel>(make_lattice(Vec3(80, 40, 20), pitch, 8).value());
    model->fill_block({Vec3::Zero(), Vec3(80, 40, 20)}, 0);
    LiveSettings settings;
    settings.tool = tool;
    settings.mode = Mode::off;
    for (const Material& material : known_materials())
      if (material.name == wood) settings.materials = {material};
    EXPECT_EQ(settings.materials.front().name, wood);
    if (!grained) set_isotropic(settings.materials.front(), kU);
    settings.spring.strength_n = strength_n;
    settings.spring.stiffness_n_mm = strength_n / kHandGiveMm;
    settings.spring.hand_share = powered ? kPoweredShare : 1;
    settings.idle_s = 1e9;
    auto device = std::make_unique<PointerDevice>(settings.rate_hz);
    pointer = device.get();
    auto made = LiveCarving::make(std::move(model), std::move(device), settings);
    EXPECT_TRUE(made.ok()) << made.error();
    live = std::move(made).value();
  }
  double u() const {
    return live->context().settings().materials.front().u *
           live->context().settings().spring.hand_share;
  }
  const Vec3& tip() const { return tip_; }

  void tick(int ticks = 1) {
    for (int i = 0; i < ticks; i++) {
      pointer->pump();
      const LiveTick t = live->tick(0.001);
      computed = t.computed;
      inside = t.inside;
      tip_ = t.tool.tip;
    }
    removed_mm3 = live->totals().removed_mm3;
  }
  void press(const Pose& pose, double time_s, Mode mode = Mode::cut) {
    stroke = pointer->begin(pose, time_s);
    ASSERT_TRUE(live->post([this, pose, mode, number = stroke](ServoContext& l) {
      l.settings().mode = mode;
      pointer->follow(number, l.place_clear(pose).value_or(pose));
    }));
  }
  // Runs until all of the path was followed.
  void finish() {
    pointer->end();
    for (int i = 0; i < 100000 && pointer->finished() < stroke; i++) tick();
    EXPECT_EQ(pointer->finished(), stroke);
  }
  void lift() {
    ASSERT_TRUE(live->post([this, number = stroke](ServoContext& l) {
      l.settings().mode = Mode::off;
      pointer->give_up(number);
    }));
    tick(2);
  }
  uint64_t hash() { return live->context().model().content_hash(); }

 private:
  Vec3 tip_ = Vec3::Zero();
};

Pose upright(double x, double y, double z) { return {Vec3(x, y, z), Mat3::Identity()}; }

// Section of a ball's groove of depth d.
double groove_mm2(double r, double d) {
  return r * r * std::acos((r - d) / r) - (r - d) * std::sqrt(2 * r * d - d * d);
}

// A straight stroke along x at the depth `deep`, which takes `ms` milliseconds. Calls `each` after
// each event.
void straight(
    Bench& bench, double from, double to, double deep, double ms,
    const std::function<void()>& each = [] {}) {
  bench.press(upright(from, 20, 20 - deep), 5);
  for (double t = 4; t < ms; t += 4) {
    bench.pointer->move(upright(from + (to - from) * t / ms, 20, 20 - deep), 5 + t / 1000);
    each();
  }
  bench.pointer->move(upright(to, 20, 20 - deep), 5 + ms / 1000);
}

TEST(Hand, AGrooveInOakAnswersAsOakDoes) {
  // 9.83 mm^2 of oak at 25 N/mm^2 need about 245 N. This hand has 1000 N.
  Bench bench("oak", BallTool{4}, false, 1000, 0.25, false);
  double sum = 0;
  int count = 0;
  straight(bench, 15, 60, 2, 500, [&] {
    for (int i = 0; i < 4; i++) {
      bench.tick();
      if (bench.tip().x() > 30 && bench.tip().x() < 50) sum += bench.computed.force.norm(), count++;
    }
  });
  bench.finish();
  ASSERT_GT(count, 100);
  const double expected = 25 * groove_mm2(4, 2) + 1;
  EXPECT_NEAR(sum / count, expected, 0.03 * expected);
  // While the pointer rests, the force stays. After it is lifted, the force is 0.
  const double held = bench.computed.force.norm();
  bench.tick(200);
  EXPECT_EQ(bench.computed.force.norm(), held);
  EXPECT_GT(held, 0.8 * expected);
  bench.lift();
  EXPECT_EQ(bench.computed.force.norm(), 0);
}

// Along its fibres, which are parallel to the block, oak needs k = 10 N/mm^1.5. The groove of a
// ball is the segment of a circle. Its width is that of a rectangle of equal variance. Rings vary
// the force.
TEST(Hand, AlongTheGrainOakFollowsItsLaw) {
  Bench bench("oak", BallTool{4}, false, 1000);
  double sum = 0;
  int count = 0;
  straight(bench, 15, 65, 2, 500, [&] {
    for (int i = 0; i < 4; i++) {
      bench.tick();
      if (!(bench.tip().x() > 20 && bench.tip().x() < 60)) continue;
      sum += bench.computed.force.norm(), count++;
    }
  });
  bench.finish();
  ASSERT_GT(count, 100);
  double area = 0, variance = 0;
  for (double y = -4; y < 4; y += 1e-3) {
    const double high = std::max(0.0, std::sqrt(16 - y * y) - 2);
    area += 1e-3 * high;
    variance += 1e-3 * high * y * y;
  }
  const double width = std::sqrt(12 * variance / area), thick = area / width;
  const double expected = 10 * width * (1 + 0.5 * (thick - 1)) + 0.6;
  EXPECT_NEAR(sum / count, expected, 0.3 * expected);
}

TEST(Hand, DepthYieldsBeforeThePathDoes) {
  // 200 N are enough for 8 mm^2 of oak, but a groove 2 mm deep has 9.83 mm^2. So the tool cuts less
  // deep.
  Bench bench("oak", BallTool{4}, false, 200, 0.25, false);
  straight(bench, 15, 65, 2, 500);
  bench.finish();
  EXPECT_NEAR(bench.tip().x(), 65, 0.3);
  const double before = bench.removed_mm3, from = bench.tip().x();
  EXPECT_NEAR(bench.computed.force.norm(), 200, 20);
  double deep = 0, area = 199.0 / 25;
  while (groove_mm2(4, deep) < area) deep += 1e-4;
  EXPECT_NEAR(20 - bench.tip().z(), deep, 0.1);  // rows of rays are 0.25 mm apart
  EXPECT_GT(before, 0.85 * area * (from - 15));
  EXPECT_LT(before, 1.1 * area * (from - 15) + 2 * kPi * 16);
}

// Section of the groove of a tool of revolution, and the volume of both ends together, by slices.
// The tool has the radius r(z) at the height z above its tip.
template <class R>
std::pair<double, double> groove_of(double deep, R&& r) {
  double section = 0, ends = 0;
  constexpr int kSlices = 20000;
  for (int i = 0; i < kSlices; i++) {
    const double radius = r((i + 0.5) * deep / kSlices);
    section += 2 * radius * deep / kSlices;
    ends += kPi * radius * radius * deep / kSlices;
  }
  return {section, ends};
}

// A flick (a quick stroke) cuts its whole groove and ends at the end of the pointer's path, at any
// speed, place and direction.
TEST(Hand, AFlickIsAllOfItsGroove) {
  const struct {
    Tool tool;
    std::pair<double, double> groove;
  } kTools[] = {
      {BallTool{4}, groove_of(2, [](double z) { return std::sqrt(z * (8 - z)); })},
      {Flat{4, 25}, groove_of(2, [](double) { return 4.0; })},
      {Bull{4, 1.5, 25}, groove_of(2,
                                   [](double z) {
                                     return z < 1.5 ? 2.5 + std::sqrt(2.25 - (1.5 - z) * (1.5 - z))
                                                    : 4;
                                   })},
      {Cone{90, 4, 25}, groove_of(2, [](double z) { return z; })},
  };
  Random random;
  for (const auto& [tool, groove] : kTools)
    for (const char* wood : {"limewood", "oak", "walnut"})
      for (const double ms : {60.0, 100.0, 250.0, 1000.0}) {
        Bench bench(wood, tool, true);
        const Vec3 from(random.uniform(8, 14), random.uniform(10, 30), 18);
        const Vec3 to(random.uniform(60, 70), random.uniform(10, 30), 18);
        bench.press({from, Mat3::Identity()}, 5);
        for (double t = 4; t < ms; t += 4)
          bench.pointer->move({from + (to - from) * t / ms, Mat3::Identity()}, 5 + t / 1000);
        bench.pointer->move({to, Mat3::Identity()}, 5 + ms / 1000);
        bench.finish();
        const double expected = (to - from).norm() * groove.first + groove.second;
        EXPECT_NEAR(bench.removed_mm3, expected, 0.02 * expected)
            << tool.index() << " in " << wood << ", " << ms << " ms" << random.note();
        EXPECT_LT((bench.tip() - to).norm(), 0.3)
            << tool.index() << " in " << wood << ", " << ms << " ms";
      }
}

// A wide gouge leaves the same groove at any speed, without chatter marks. 200 N are enough for 2
// mm of oak along its fibres, which need 160 N by the law. 150 N cut slightly less deep.
TEST(Hand, AWideGougeCutsTheSameGrooveAtAnySpeed) {
  for (const auto& [strength, depth, waves] : {std::tuple{200.0, 2.0, 0.02}, {150.0, 1.86, 0.07}}) {
    double first = 0;
    for (const double ms : {250.0, 500.0, 1000.0, 2000.0}) {
      Bench bench("oak", Gouge{7, 12, 1.5, 60}, false, strength, 0.4);
      const Mat3 frame = frame_from_axis(Vec3(-0.6, 0, 0.8));
      const auto at = [&](double t) {
        const double along = 53 * t / ms;
        return Pose{Vec3(12 + along, 20.1, 20.3 - std::min(2.3, 0.5 * along)), frame};
      };
      bench.press(at(0), 5);
      for (double t = 4; t < ms; t += 4) bench.pointer->move(at(t), 5 + t / 1000);
      bench.pointer->move(at(ms), 5 + ms / 1000);
      bench.pointer->end();
      double sum = 0, squares = 0;
      int count = 0;
      for (int i = 0; i < 100000 && bench.pointer->finished() < bench.stroke; i++) {
        bench.tick();
        if (bench.tip().x() < 28 || bench.tip().x() > 60) continue;
        const double deep = 20 - bench.tip().z();
        sum += deep;
        squares += deep * deep;
        count++;
      }
      ASSERT_GT(count, 10);
      const double mean = sum / count;
      EXPECT_NEAR(mean, depth, 0.06) << strength << " N, " << ms << " ms";
      EXPECT_LT(std::sqrt(std::max(0.0, squares / count - mean * mean)), waves)
          << strength << " N, " << ms << " ms";
      if (first == 0) first = bench.removed_mm3;
      EXPECT_NEAR(bench.removed_mm3, first, 0.02 * first) << strength << " N, " << ms << " ms";
    }
  }
}

// The result depends only on the path, not on the delay of events or on their number per tick.
TEST(Hand, WhatIsCarvedIsAFunctionOfThePath) {
  Random random;
  for (const bool powered : {true, false}) {
    struct Event {
      Pose pose;
      double time_s;
    };
    std::vector<Event> path;
    double time = 100, x = 20, y = 20;
    Vec3 axis = Vec3::UnitZ();
    for (int i = 0; i < 150; i++) {
      path.push_back({{Vec3(x, y, 20 - random.uniform(0.5, 2.5)), frame_from_axis(axis)}, time});
      x = std::clamp(x + random.uniform(-3, 4), 5.0, 75.0);
      y = std::clamp(y + random.uniform(-3, 3), 5.0, 35.0);
      axis = (axis + 0.1 * random.direction()).normalized();
      if (axis.z() < 0.7) axis = Vec3::UnitZ();
      time += i % 40 == 39 ? random.uniform(0.2, 2) : random.uniform(0.001, 0.03);
    }
    std::vector<uint64_t> hashes;
    for (int how = 0; how < 4; how++) {
      Bench bench("walnut", how < 0 ? Tool{} : Tool{BallTool{3}}, powered, 200, 0.5);
      bench.press(path.front().pose, path.front().time_s);
      for (size_t i = 1; i < path.size(); i++) {
        bench.pointer->move(path[i].pose, path[i].time_s);
        if (how == 1) bench.tick(3);                  // while it waits
        if (how == 2 && i % 17 == 0) bench.tick(20);  // in batches
        if (how == 3) bench.tick(static_cast<int>(random.uniform(0, 9)));
      }
      bench.finish();
      bench.lift();
      EXPECT_GT(bench.removed_mm3, 100);
      hashes.push_back(bench.hash());
    }
    for (const uint64_t hash : hashes) EXPECT_EQ(hash, hashes.front()) << random.note();
  }
}

const std::vector<std::pair<Tool, bool>>& tools() {
  static const std::vector<std::pair<Tool, bool>> list = {
      {BallTool{4}, true},      {Finger{0.25, 20}, false},        {Flat{4, 25}, true},
      {Bull{4, 1.5, 25}, true}, {Cone{90, 4, 25}, true},          {Cone{118, 4, 25}, true},
      {Capsule{4, 33}, false},  {BoxTool{Vec3(8, 4, 25)}, false}, {Ellipsoid{Vec3(4, 6, 4)}, false},
  };
  return list;
}

// Every tool cuts in every wood, in any direction, at the studio's default depth.
TEST(Hand, EveryToolBitesInEveryWood) {
  for (const auto& [tool, powered] : tools())
    for (const char* wood : {"limewood", "oak", "walnut", "wax"})
      for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(0.5, -0.6, 0.65)}) {
        Bench bench(wood, tool, powered, 200, 0.5);
        const Vec3 up = axis.normalized();
        const Mat3 frame = frame_from_axis(up);
        const auto at = [&](double x) { return Pose{Vec3(x, 20, 20) - 2 * up, frame}; };
        bench.press(at(25), 1);
        for (int i = 1; i <= 50; i++) bench.pointer->move(at(25 + 0.6 * i), 1 + 0.008 * i);
        bench.finish();
        EXPECT_FALSE(bench.inside);
        EXPECT_GT(bench.removed_mm3, 20)
            << tool.index() << " in " << wood << " along " << axis.transpose();
        EXPECT_LE(bench.computed.force.norm(), 201);
        // Only the depth along the axis may be smaller than requested.
        const Vec3 off = bench.tip() - at(55).tip;
        EXPECT_LT((off - off.dot(up) * up).norm(), 0.3) << tool.index() << " in " << wood;
      }
}

// The default tool and depth need at most 0.8 of the hand's strength in every wood.
TEST(Hand, TheStartingToolSinksInEveryWood) {
  for (const Material& material : known_materials()) {
    if (!has_chip_law(material)) continue;
    Bench bench(material.name.c_str(), BallTool{4}, true);
    bench.press(upright(40, 20, 18), 1);
    bench.finish();
    EXPECT_NEAR(bench.tip().z(), 18, kHandGiveMm) << material.name;
    EXPECT_LE(bench.computed.force.norm(), 160) << material.name;
  }
}

// A plunge stops where the wood's resistance equals the hand's strength: u dV/dz = S.
TEST(Hand, APlungeReachesTheDepthOfItsStrength) {
  for (const double strength : {50.0, 200.0, 800.0}) {
    Bench bench("oak", BallTool{4}, false, strength, 0.25, false);
    bench.press(upright(40, 20, 16), 1);
    bench.finish();
    double deep = 0;
    while (kU * kPi * (8 * deep - deep * deep) + 1 < strength) deep += 1e-4;
    EXPECT_NEAR(20 - bench.tip().z(), deep, 0.08 + 0.05 * deep) << strength;
    EXPECT_NEAR(bench.computed.force.norm(), strength, 0.02 * strength);
  }
}

// The force on a blade that turns with a bend is as steady as on a straight path. From tick to tick
// it changes by a small share.
TEST(Hand, ABladeThatTurnsWithABendDoesNotShake) {
  const auto shaking = [](double radius) {
    Bench bench("walnut", Vee{60, 8, 1, 25}, false, 400, 0.4, false);
    StrokeGuideSettings settings;
    settings.lead = true;
    settings.entry_mm = 4;
    settings.lift_mm = 2.5;
    StrokeGuide guide(settings);
    const auto at = [&](double along) {
      const double angle = along / radius;
      return Pose{Vec3(15 + radius * std::sin(angle), 8 + radius * (1 - std::cos(angle)), 18),
                  frame_from_axis(Vec3::UnitZ())};
    };
    std::vector<std::pair<Pose, double>> path;
    const auto take = [&](const Pose& pose, double s) { path.emplace_back(pose, s); };
    take(guide.begin(at(0), 0), 0);
    for (int i = 1; i <= 300; i++) guide.move(at(0.1 * i), 0.002 * i, take);
    guide.end(take);
    bench.press(path.front().first, path.front().second);
    for (size_t i = 1; i < path.size(); i++) bench.pointer->move(path[i].first, path[i].second);
    // Counts only ticks in which the tool has had its full depth for a while.
    double changes = 0, sum = 0, last = 0;
    int count = 0, within = 0;
    for (int i = 0; i < 500; i++) {
      bench.tick();
      const double force = bench.computed.force.norm();
      within = bench.tip().z() < 18.3 ? within + 1 : 0;
      if (within > 5) changes += std::abs(force - last), sum += force, count++;
      last = force;
    }
    EXPECT_GT(count, 30);
    EXPECT_GT(sum / count, 15);
    return changes / sum;
  };
  EXPECT_LT(shaking(1e6), 0.08);
  EXPECT_LT(shaking(16), 0.08);
}

// In the paper's method, Ks may change at any moment. A blunter finger backs out and enters again.
TEST(Hand, ABlunterFingerContinuesCutting) {
  Bench bench("limewood", Finger{0.5, 20}, true);
  straight(bench, 20, 40, 2, 200);
  bench.tick(400);
  const double before = bench.removed_mm3;
  ASSERT_TRUE(bench.live->post([](ServoContext& l) { l.change_tool(Finger{0.05, 20}); }));
  for (int i = 1; i <= 50; i++) bench.pointer->move(upright(40 + 0.4 * i, 20, 18), 5.2 + 0.004 * i);
  bench.finish();
  EXPECT_FALSE(bench.inside);
  // Its groove is three times as wide.
  EXPECT_GT(bench.removed_mm3 - before, 20 * 4.0 / 3 * std::pow(2, 1.5) / std::sqrt(0.05) * 0.7);
}

// A blow does 3 J of work, or less if the target is reached.
TEST(Hand, AMalletDrivesAHandTool) {
  Bench bench("oak", BoxTool{Vec3(8, 4, 25)}, false, 200, 0.25, false);
  bench.press(upright(40, 20, 12), 1);
  bench.tick(60);
  EXPECT_LT(bench.removed_mm3, 1);  // 32 mm^2 of oak would take 800 N
  double last = bench.removed_mm3;
  for (int blow = 0; blow < 2; blow++) {
    ASSERT_TRUE(bench.live->post([](ServoContext& l) { l.strike(3000); }));
    bench.tick(5);
    EXPECT_NEAR(bench.removed_mm3 - last, 3000 / 25.0, 0.03 * 120);
    last = bench.removed_mm3;
  }
  for (int blow = 0; blow < 3; blow++) {
    ASSERT_TRUE(bench.live->post([](ServoContext& l) { l.strike(3000); }));
    bench.tick(5);
  }
  EXPECT_NEAR(bench.removed_mm3, 32 * 8, 2);
  EXPECT_NEAR(bench.tip().z(), 12, 1e-6);
  bench.finish();
}

// A tool that cannot back out along its axis cuts nothing and reports that.
TEST(Hand, ABlockedToolIsReported) {
  Bench bench("limewood", BallTool{2}, true);
  bench.press(upright(40, 20, 2), 1);  // 18 mm below the surface, farther than twice its size
  bench.finish();
  EXPECT_TRUE(bench.inside);
  EXPECT_EQ(bench.removed_mm3, 0);
}

}  // namespace
}  // namespace kibori::hand_tests
