// SPDX-License-Identifier: MIT
// Two hands on one model: each gets the force of its own tool. In a tick they edit one after the
// other. The document replays to the same bytes.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include <gtest/gtest.h>

#include <kibori/run/carving.h>
#include <kibori/run/documents.h>
#include <kibori/run/replay.h>
#include <kibori/report/force_report.h>
#include <kibori/devices/pointer_device.h>
#include <kibori/live/document_writer.h>

#include "tests/live_rig.h"
#include "tests/support.h"

namespace kibori::two_hands_tests {
namespace {

using test::arm;
using test::block;
using test::Folder;
using test::Random;

using Script = VirtualDevice::Script;

std::unique_ptr<Device> device(Script script) {
  VirtualDeviceSettings settings;
  settings.capabilities = arm();
  return std::make_unique<VirtualDevice>(settings, std::move(script));
}

ServoHandSettings hand(const Tool& tool, Mode mode) {
  ServoHandSettings settings;
  settings.tool = tool;
  settings.mode = mode;
  settings.spring.stiffness_n_mm = 1;
  settings.spring.torsion_nmm_rad = 20;
  settings.workspace = Workspace(Vec3(20, 15, 25));
  return settings;
}

LiveSettings both(const ServoHandSettings& first, const ServoHandSettings& second,
                  ForceModel model) {
  LiveSettings settings;
  static_cast<ServoHandSettings&>(settings) = first;
  settings.second = second;
  settings.model = model;
  settings.materials[0].u = 0.02;
  settings.log = true;
  return settings;
}

// `pushes`: the force moves the hands.
std::unique_ptr<LiveCarving> two(const LiveSettings& settings, Script first, Script second,
                                 bool pushes = true) {
  auto live =
      LiveCarving::make(block(0.5), device(std::move(first)), settings, device(std::move(second)));
  EXPECT_TRUE(live.ok()) << live.error();
  if (!pushes) return std::move(live).value();
  live.value()->context().safety().arm();
  live.value()->context().second()->safety().arm();
  return std::move(live).value();
}

// A random path: back and forth over the block, in and out of its top. The tool also turns.
Script wander(Random& random) {
  const Vec3 amplitude(random.uniform(3, 18), random.uniform(3, 13), random.uniform(2, 5)),
      speed = random.in_box(2, 6), phase = random.in_box(0, 6);
  const double turn = random.uniform(0, 0.4);
  return [=](double t) {
    return VirtualDevice::Target{Vec3(amplitude.x() * std::sin(speed.x() * t + phase.x()),
                                      amplitude.y() * std::cos(speed.y() * t + phase.y()),
                                      -4.5 + amplitude.z() * std::cos(speed.z() * t + phase.z())),
                                 rotation(Vec3(turn * std::sin(3 * t), turn * std::cos(2 * t), 0)),
                                 0};
  };
}

void expect_sound(const std::filesystem::path& file, uint64_t hash) {
  auto after = Document::open(file, Document::Access::read);
  ASSERT_TRUE(after.ok()) << after.error();
  EXPECT_TRUE(after.value()->verify([](const std::string& wrong) { ADD_FAILURE() << wrong; }).ok());
  const auto bodies = after.value()->load_bodies(after.value()->head());
  ASSERT_TRUE(bodies.ok()) << bodies.error();
  EXPECT_EQ(bodies.value().content_hash(), hash) << bodies.value().all.size() << " bodies";
}

// A hand that cuts gets a force. A hand in the air gets none. If both cut, each hand gets the same
// force as when it cuts alone.
TEST(TwoHands, EachHandHasItsOwnForce) {
  const auto stroke = [](double x) {
    return [x](double t) {
      return VirtualDevice::Target{Vec3(x, -20 + 80 * t, -5.8), Mat3::Identity(), 0};
    };
  };
  const Script air = [](double) { return test::down(3); };
  for (const ForceModel model : {ForceModel::series, ForceModel::energy, ForceModel::paper}) {
    const auto force = [&](const Script& a, const Script& b) {
      const auto live =
          two(both(hand(BallTool{2}, Mode::cut), hand(BallTool{2}, Mode::cut), model), a, b);
      Vec3 first = Vec3::Zero(), second = Vec3::Zero();
      double removed = 0;
      const double before = live->context().model().volume_mm3();
      for (int i = 0; i < 300; i++) {
        const LiveTick tick = live->tick(0.001);
        EXPECT_TRUE(tick.second);
        first += tick.computed.force;
        second += tick.second->computed.force;
        removed += tick.removed_mm3 + tick.second->removed_mm3;
      }
      EXPECT_NEAR(removed, before - live->context().model().volume_mm3(), 1e-3 * (1 + removed));
      EXPECT_NEAR(removed, live->totals().removed_mm3, 1e-9 * (1 + removed));
      return std::pair(first, second);
    };
    const auto [left, none] = force(stroke(-10), air);
    EXPECT_GT(left.norm(), 0.1) << name_of(model);
    EXPECT_EQ(none, Vec3::Zero());
    const auto [nothing, right] = force(air, stroke(10));
    EXPECT_EQ(nothing, Vec3::Zero());
    const auto [left_again, right_again] = force(stroke(-10), stroke(10));
    // Not bit for bit: the search for the balance reuses results for an unchanged model, and the
    // other hand changes the model.
    EXPECT_LT((left_again - left).norm(), 1e-4 * left.norm()) << name_of(model);
    EXPECT_LT((right_again - right).norm(), 1e-4 * right.norm()) << name_of(model);
  }
}

// If both tools are in the same wood in the same tick, the first removes it.
TEST(TwoHands, ATickThatBothUseIsInOrder) {
  const Script same = [](double t) {
    return VirtualDevice::Target{Vec3(-10 + 40 * t, 0, -6), Mat3::Identity(), 0};
  };
  const auto live =
      two(both(hand(BallTool{2}, Mode::cut), hand(BallTool{2}, Mode::cut), ForceModel::energy),
          same, same, false);
  double first = 0, second = 0;
  for (int i = 0; i < 300; i++) {
    const LiveTick tick = live->tick(0.001);
    first += tick.removed_mm3;
    second += tick.second->removed_mm3;
  }
  EXPECT_GT(first, 10);
  EXPECT_EQ(second, 0);
}

// Random tools, which may cut, deposit or only touch. The document stores both hands' strokes. Its
// replay gives the same bytes, settings and forces.
TEST(TwoHands, TheDocumentCarvesItAgain) {
  Random random;
  SCOPED_TRACE(random.note());
  const auto tool = [&]() -> Tool {
    const Tool tools[] = {BallTool{random.uniform(1, 4)}, Finger{0.2, 20}, Flat{2, 15},
                          Bull{3, 1, 12}, Cone{60, 3, 15}};
    return tools[random.integer(0, static_cast<int>(std::size(tools)) - 1)];
  };
  const int rounds = test::rounds_of("KIBORI_TWO_HANDS", 12);
  int strokes = 0;
  for (int round = 0; round < rounds; round++)
    for (const ForceModel model : {ForceModel::series, ForceModel::energy}) {
      Folder folder;
      const std::filesystem::path file = folder.path / "two.kibori";
      const Mode modes[] = {Mode::cut, Mode::cut, Mode::deposit, Mode::touch};
      LiveSettings settings = both(hand(tool(), modes[random.integer(0, 2)]),
                                   hand(tool(), modes[random.integer(0, 3)]), model);
      settings.crumbs = static_cast<Crumbs>(random.integer(0, 3));
      settings.idle_s = 0.02;
      if (random.integer(0, 2) == 0) {
        settings.symmetry.planes = {true, false, false};
        settings.symmetry.centre_mm = Vec3(20, 15, 10);
      }
      const auto live = two(settings, wander(random), wander(random));
      auto document = Document::create(file, live->context().model(), "{}");
      ASSERT_TRUE(document.ok()) << document.error();
      DocumentWriter writer(*live, std::move(document).value(), true);
      for (int i = 0; i < 1200; i++) {
        live->tick(0.001);
        if (i % 50 == 0) writer.write();
        if (i == 700) live->cancel_stroke();
      }
      live->context().finish_stroke();
      writer.write();
      EXPECT_EQ(writer.write_error(), "");
      for (const auto& [id, step] : writer.document().steps()) {
        if (step.stock) continue;
        const auto kept = writer.document().settings(id);
        ASSERT_TRUE(kept.ok()) << kept.error();
        ASSERT_TRUE(kept.value().second);
        EXPECT_EQ(kept.value().second->mode, settings.second.mode);
        strokes++;
      }
      expect_sound(file, writer.document().steps().at(writer.document().head()).hash);
    }
  EXPECT_GT(strokes, rounds);
}

// The second hand is a pointer. It is put down and lifted while the first hand carves. Both form
// one stroke, and one undo reverts it.
TEST(TwoHands, ASecondPointerJoinsAndLeavesWithinAStroke) {
  Folder folder;
  const std::filesystem::path file = folder.path / "two.kibori";
  auto made_first = std::make_unique<PointerDevice>(1000),
       made_second = std::make_unique<PointerDevice>(1000);
  PointerDevice *const first = made_first.get(), *const second = made_second.get();
  LiveSettings settings = both(ServoHandSettings(), ServoHandSettings(), ForceModel::series);
  settings.spring = settings.second.spring = spring_of_hand();
  settings.mode = Mode::off;
  settings.second.mode = Mode::deposit;
  settings.second.tool = Flat{2, 6};
  settings.tool = BallTool{2};
  settings.second.while_pressed = true;
  settings.idle_s = 1e9;
  auto live =
      LiveCarving::make(block(0.5), std::move(made_first), settings, std::move(made_second));
  ASSERT_TRUE(live.ok()) << live.error();
  LiveCarving& l = *live.value();
  auto document = Document::create(file, l.context().model(), "{}");
  ASSERT_TRUE(document.ok()) << document.error();
  DocumentWriter writer(l, std::move(document).value(), true);
  const auto at = [](double x, double y, double z) {
    return Pose{Vec3(x, y, z), Mat3::Identity()};
  };
  // A hand's path. A tick takes 1 ms.
  struct HandPath {
    PointerDevice* pointer;
    Pose from;
    Vec3 step_mm;
    double time_s;
    int done = 0;
  };
  std::vector<HandPath> paths;
  const auto run = [&](int ticks) {
    LiveTick all;
    all.second.emplace();
    for (int i = 0; i < ticks; i++) {
      for (HandPath& path : paths) {
        path.done++;
        Pose next = path.from;
        next.tip += path.done * path.step_mm;
        path.pointer->move(next, path.time_s + 0.001 * path.done);
      }
      const LiveTick tick = l.tick(0.001);
      all.removed_mm3 += tick.removed_mm3;
      all.second->removed_mm3 += tick.second->removed_mm3;
      writer.write();
    }
    return all;
  };
  const uint64_t fresh = l.context().model().content_hash();
  second->hover(at(30, 15, 40));
  run(5);
  const auto stroke = [&](PointerDevice& pointer, const Pose& from, const Pose& to, double time_s) {
    const uint32_t number = pointer.begin(from, time_s);
    paths.push_back({&pointer, from, Vec3((to.tip - from.tip) / 300), time_s});
    return number;
  };
  const uint32_t one = stroke(*first, at(5, 8, 19), at(35, 8, 19), 1);
  ASSERT_TRUE(l.post([&](ServoContext& c) {
    c.settings().mode = Mode::cut;
    first->follow(one, c.place_clear(at(5, 8, 19)).value());
  }));
  EXPECT_GT(run(100).removed_mm3, 10);
  const uint32_t other = stroke(*second, at(30, 22, 18), at(10, 22, 18), 7);
  ASSERT_TRUE(l.post_within_stroke([&](ServoContext& c) {
    c.put_second(at(30, 22, 18));
    second->follow(other, at(30, 22, 18));
  }));
  const LiveTick together = run(60);
  EXPECT_GT(together.removed_mm3, 1);
  EXPECT_LT(together.second->removed_mm3, -1);
  paths.pop_back();
  second->end();
  run(100);
  EXPECT_EQ(second->finished(), other);
  ASSERT_TRUE(l.post_within_stroke([&](ServoContext&) { second->give_up(other); }));
  second->hover(at(0, 0, 60));  // the pointer jumps; the tool is placed there and does not cut
  EXPECT_EQ(run(50).second->removed_mm3, 0);
  paths.clear();
  first->end();
  run(100);
  ASSERT_TRUE(l.post([&](ServoContext& c) {
    c.settings().mode = Mode::off;
    first->give_up(one);
  }));
  run(100);
  EXPECT_EQ(writer.document().steps().size(), 2u);
  const uint64_t carved = l.context().model().content_hash();
  EXPECT_NE(carved, fresh);
  EXPECT_EQ(writer.document().steps().at(writer.document().head()).hash, carved);
  // Alone, the second hand's stroke ends when it is lifted. The first hand, which jumps meanwhile,
  // does not interrupt it.
  const uint32_t alone = stroke(*second, at(20, 15, 19), at(25, 15, 19), 20);
  ASSERT_TRUE(l.post_within_stroke([&](ServoContext& c) {
    c.put_second(at(20, 15, 19));
    second->follow(alone, at(20, 15, 19));
  }));
  run(20);
  first->hover(at(0, 0, 80));
  run(20);
  first->hover(at(38, 28, 60));
  run(20);
  paths.clear();
  second->end();
  run(400);
  EXPECT_EQ(writer.document().steps().size(), 3u);
  for (const uint64_t wanted : {carved, fresh}) {
    writer.undo();
    for (int i = 0; i < 2000 && !writer.idle(); i++) {
      run(1);
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    EXPECT_TRUE(writer.idle());
    EXPECT_EQ(l.context().model().content_hash(), wanted);
  }
  l.context().finish_stroke();
  writer.write();
  expect_sound(file, fresh);
}

// While one hand reshapes, the other only gets a force. Impossible combinations are reported.
TEST(TwoHands, OneOnlyReshapes) {
  LiveSettings settings =
      both(hand(BallTool{3}, Mode::smooth), hand(BallTool{2}, Mode::cut), ForceModel::series);
  const Script in_wood = [](double t) {
    return VirtualDevice::Target{Vec3(8, -20 + 40 * std::min(t, 0.5), -6), Mat3::Identity(), 0};
  };
  const auto live = two(
      settings, [](double) { return test::down(-5); }, in_wood);
  double removed = 0, max_force = 0;
  for (int i = 0; i < 400; i++) {
    const LiveTick tick = live->tick(0.001);
    removed += tick.second->removed_mm3;
    max_force = std::max(max_force, tick.second->computed.force.norm());
  }
  EXPECT_EQ(removed, 0);
  EXPECT_GT(max_force, 0.05);
  const auto wrong = [](const LiveSettings& s) {
    const auto made = LiveCarving::make(block(1), device([](double) { return test::down(0); }), s,
                                        device([](double) { return test::down(0); }));
    return made ? std::string() : made.error();
  };
  settings.second.mode = Mode::smooth;
  EXPECT_NE(wrong(settings).find("is only for the first hand"), std::string::npos);
  settings.second = hand(BallTool{-1}, Mode::cut);
  EXPECT_NE(wrong(settings), "");
}

constexpr const char* kScene = R"(schema = 1
[stock]
block = [40, 30, 20]
pitch = 0.5
[tool]
shape = "ball"
radius = 2
[[move]]
to = [5, 8, 25]
second = { to = [35, 22, 25], tool = { shape = "flat", radius = 2, length = 8 } }
[[move]]
to = [5, 8, 18]
speed = 40
second = { to = [35, 22, 17] }
[[move]]
to = [35, 8, 18]
second = { to = [5, 22, 17] }
[[move]]
to = [35, 12, 19]
second = { mode = "deposit" }
[[move]]
to = [20, 26, 25]
second = { to = [20, 4, 25], mode = "off" }
)";

TEST(TwoHands, AScene) {
  const auto scene = parse_scene(kScene, "two.toml", ".");
  ASSERT_TRUE(scene) << scene.error();
  Folder folder;
  CarveOptions options;
  options.document = folder.path / "scene.kibori";
  options.keep_forces = true;
  const auto carving = carve(scene.value(), options);
  ASSERT_TRUE(carving) << carving.error();
  const CarveSummary& s = carving.value().summary;
  EXPECT_NEAR(s.volume_mm3, 24000 - s.removed_mm3 + s.deposited_mm3, 1e-3);
  EXPECT_GT(s.deposited_mm3, 0);
  // The cuts of the two hands do not overlap. So the volumes that each hand removes alone add up to
  // the volume that both remove.
  double alone = 0;
  for (const bool first : {true, false}) {
    std::string text = kScene;
    const std::string cuts = "second = { mode = \"deposit\" }";
    text.replace(text.find(cuts), cuts.size(), "second = { mode = \"off\" }");
    if (first)
      text.replace(text.find("second = { to"), 13, "second = { mode = \"off\", to");
    else
      text.replace(text.find("to = [5, 8, 25]"), 0, "mode = \"off\"\n");
    const auto part = parse_scene(text, "two.toml", ".");
    ASSERT_TRUE(part) << part.error();
    alone += carve(part.value(), {}).value().summary.removed_mm3;
  }
  EXPECT_NEAR(alone, s.removed_mm3, 1e-6 * alone);
  // The CSV has a header, and one row for each hand in each tick.
  const std::string csv = forces_csv(carving.value());
  EXPECT_EQ(csv.substr(0, csv.find('\n')).substr(csv.find("mz_Nmm")), "mz_Nmm,hand");
  EXPECT_EQ(static_cast<size_t>(std::count(csv.begin(), csv.end(), '\n')),
            1 + 2 * carving.value().trace.size());
  expect_sound(options.document, s.state_hash);
  const auto document = Document::open(options.document, Document::Access::read);
  ASSERT_TRUE(document.ok());
  const auto replay = replay_document(*document.value(), {});
  ASSERT_TRUE(replay.ok()) << replay.error();
  EXPECT_EQ(replay.value().differs, 0);
  EXPECT_EQ(replay.value().carving.summary.ticks, s.ticks);
  EXPECT_NEAR(replay.value().carving.summary.removed_mm3, s.removed_mm3, 1e-9 * s.removed_mm3);
}

TEST(TwoHands, AnInvalidSceneIsExplained) {
  const auto wrong = [](const std::string& from, const std::string& to) {
    std::string text = kScene;
    text.replace(text.find(from), from.size(), to);
    const auto scene = parse_scene(text, "two.toml", ".");
    return scene ? std::string() : scene.error();
  };
  EXPECT_NE(wrong("second = { to = [35, 22, 25], tool", "label = \"a\"\n#").find("first move"),
            std::string::npos);
  EXPECT_NE(wrong("mode = \"deposit\"", "mode = \"smooth\"").find("is only for the first hand"),
            std::string::npos);
  EXPECT_NE(wrong("to = [35, 12, 19]", "to = [35, 12, 19]\nmode = \"smooth\"").find("can't work"),
            std::string::npos);
  EXPECT_NE(wrong("mode = \"off\"", "depth = 3").find("depth"), std::string::npos);
  EXPECT_NE(wrong("second = { mode = \"deposit\" }", "second = 3"), "");
}

}  // namespace
}  // namespace kibori::two_hands_tests
