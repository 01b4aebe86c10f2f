// SPDX-License-Identifier: MIT
// Documents of several bodies: every state against full copies; a kill during a split; modified
// rows; a hand that carves a moved body.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <map>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include <kibori/body/workbench.h>
#include <kibori/devices/virtual_device.h>
#include <kibori/live/document_writer.h>
#include <kibori/surface/surface.h>

#include "tests/document_support.h"
#include "tests/reshape_support.h"
#include "tests/surface_check.h"

namespace kibori::document_bodies_tests {
namespace {

using namespace test;

constexpr Crumbs kRules[] = {Crumbs::sort, Crumbs::stay, Crumbs::fall, Crumbs::body};

SplineShape any_spline(Random& random) {
  SplineShape shape;
  shape.kind = static_cast<SplineKind>(random.integer(0, 2));
  shape.curve.closed = shape.kind == SplineKind::extrude;
  shape.curve.interpolate = random.integer(0, 1) == 1;
  const Vec3 at = random.in_box(8, 22);
  for (int i = 0; i < 5; i++) {
    const double angle = 2 * 3.14159265 * i / 5;
    if (shape.kind == SplineKind::extrude)
      shape.curve.points_mm.push_back(at + random.uniform(3, 7) *
                                               Vec3(std::cos(angle), std::sin(angle), 0));
    else if (shape.kind == SplineKind::revolve)
      shape.curve.points_mm.push_back(at + Vec3(random.uniform(2, 7), 0, 3.0 * i));
    else
      shape.curve.points_mm.push_back(at + Vec3(6.0 * i - 12, random.uniform(-3, 3), 0));
  }
  shape.axis_point_mm = at;
  shape.radius_mm = random.uniform(1, 2.5);
  return shape;
}

// A random action on some of the bodies; it may be refused.
BodyAction any_action(Random& random, const BodyList& bodies) {
  constexpr const char* kMix[] = {"cut",       "cut",      "cut",       "join",   "subtract",
                                  "intersect", "bake",     "duplicate", "mirror", "move",
                                  "move",      "separate", "remove",    "set",    "set",
                                  "add",       "spline",   "spline",    "protect"};
  BodyAction action;
  action.verb = *default_verb(kMix[random.integer(0, static_cast<int>(std::size(kMix)) - 1)]);
  const auto one = [&] {
    return bodies
        .all[static_cast<size_t>(random.integer(0, static_cast<int>(bodies.all.size()) - 1))]
        .id;
  };
  action.bodies = {one()};
  const size_t fewest = std::visit([](const auto& verb) { return verb.kRule.fewest; }, action.verb);
  if (fewest == 2) action.bodies.push_back(one());
  if (fewest == 0 && random.integer(0, 1)) action.bodies.clear();
  CutPlane plane;
  plane.point_mm = random.in_box(5, 25);
  plane.normal = random.integer(0, 2) ? random.direction() : Vec3(Vec3::Unit(random.integer(0, 2)));
  if (auto* const cut = std::get_if<BodyCut>(&action.verb)) {
    cut->cutter.shape = plane;
    if (random.integer(0, 2) == 0) cut->cutter.kerf_mm = random.uniform(0.5, 4);
  }
  if (auto* const mirror = std::get_if<BodyMirror>(&action.verb)) mirror->plane = plane;
  if (auto* const move = std::get_if<BodyMove>(&action.verb)) {
    // A turn and a shift, or only a shift. Without a turn, joining bodies stays exact.
    move->pose.tip = random.in_box(-3, 3);
    if (random.integer(0, 1)) move->pose.frame = rotation(0.3 * random.direction());
  }
  if (auto* const set = std::get_if<BodySet>(&action.verb)) {
    auto& [name, visible, locked, no_go] = set->properties;
    if (random.integer(0, 1)) name = "part <" + std::to_string(random.integer(0, 99)) + ">";
    if (random.integer(0, 1)) visible = random.integer(0, 1) == 1;
    locked = random.integer(0, 4) == 0;
    if (random.integer(0, 1)) no_go = random.integer(0, 2) == 0;
  }
  if (auto* const spline = std::get_if<BodySpline>(&action.verb))
    *spline = {any_spline(random), static_cast<SplineOperation>(random.integer(0, 5) / 2 % 3),
               static_cast<uint8_t>(random.integer(0, 1))};
  if (auto* const protect = std::get_if<BodyProtect>(&action.verb)) {
    protect->tool = BallTool{random.uniform(1, 5)};
    protect->path_mm = {random.in_box(0, 25), random.in_box(0, 25)};
    protect->follows = random.integer(0, 2) != 0;
  }
  if (auto* const add = std::get_if<BodyAdd>(&action.verb)) {
    action.bodies.clear();
    add->tool = random.integer(0, 1) ? Tool(BallTool{random.uniform(2, 8)})
                                     : Tool(BoxTool{random.in_box(2, 12)});
    add->pose.tip = random.in_box(0, 25);
    if (random.integer(0, 1)) add->pose.frame = rotation(0.3 * random.direction());
    add->material = static_cast<uint8_t>(random.integer(0, 1));
    add->properties.no_go = random.integer(0, 3) != 0;
  }
  return action;
}

struct Truth {
  uint64_t hash = 0;
  std::vector<std::string> list;  // description of each body
};
Truth truth_of(const BodyList& bodies) {
  Truth truth{bodies.content_hash(), {}};
  for (const Body& body : bodies.all) {
    char pose[400];
    std::snprintf(pose, sizeof pose, "%d %d %d %d %.17g %.17g %.17g %.17g", body.visible,
                  body.locked, body.no_go, body.mask_of, body.pose.tip.x(), body.pose.tip.z(),
                  body.pose.frame(0, 1), body.pose.frame(2, 0));
    truth.list.push_back(std::to_string(body.id) + " " + body.name + " " + pose + " " +
                         std::to_string(body.model.content_hash()));
  }
  return truth;
}

TEST(DocumentBodies, HistoryAgainstFullCopies) {
  Random random;
  SCOPED_TRACE(random.note());
  Folder folder;
  const int steps = rounds_of("KIBORI_BODY_HISTORY", 250);
  auto model = std::make_unique<TriDexel>(stock(1.5));
  auto document = created(folder / "a.kibori", *model);
  std::map<StepId, Truth> truth{{1, truth_of(BodyList::of(*model))}};
  size_t largest = 1;
  int acted = 0;
  for (int i = 0; i < steps; i++) {
    const int what = random.integer(0, 9);
    if (what < 3) {
      const std::vector<Body>& list = document->bodies_at(document->head()).all;
      const int chosen = random.integer(0, static_cast<int>(list.size()) - 1);
      ASSERT_TRUE(document->choose(list[static_cast<size_t>(chosen)].id).ok());
      ASSERT_TRUE(document->go(*model, document->head()).ok());
      if (document->bodies_at(document->head()).find(document->active())->kept()) {
        ASSERT_FALSE(document->begin({}, {}).ok());
      } else {
        carve(*document, *model, random, random.integer(1, 15), true, kRules[random.integer(0, 3)]);
      }
    } else if (what < 7) {
      // Limits the number of bodies.
      BodyAction action = any_action(random, document->bodies_at(document->head()));
      if (document->bodies_at(document->head()).all.size() > 8) action.verb = BodyRemove{};
      const StepId before = document->head();
      const auto done = document->act(action);
      if (!done) {
        ASSERT_EQ(document->head(), before) << done.error();
        ASSERT_FALSE(done.error().empty());
      }
      acted += done.ok();
      ASSERT_TRUE(document->go(*model, document->head()).ok());
    } else if (what == 7) {
      static_cast<void>(document->undo(*model));
    } else if (what == 8) {
      static_cast<void>(document->redo(*model));
    } else {
      const auto to =
          std::next(truth.begin(), random.integer(0, static_cast<int>(truth.size()) - 1));
      ASSERT_TRUE(document->go(*model, to->first).ok());
    }
    ASSERT_NE(document->worked_on(), nullptr);
    const BodyList now = *document->worked_on();
    largest = std::max(largest, now.all.size());
    const Truth is = truth_of(now);
    const auto [known, fresh] = truth.emplace(document->head(), is);
    ASSERT_EQ(is.list, known->second.list) << i;
    ASSERT_EQ(is.hash, document->steps().at(document->head()).hash) << i;
    ASSERT_EQ(model->content_hash(), now.find(document->active())->model.content_hash()) << i;
    if (fresh && random.integer(0, 4) == 0) {
      for (const Body& body : now.all) {
        EXPECT_EQ(broken(extract_surface(body.model)), "") << i << " body " << body.id;
      }
    }
    if (i % 60 == 59) {
      const StepId head = document->head();
      document.reset();
      document = opened(folder / "a.kibori");
      ASSERT_NE(document, nullptr);
      ASSERT_EQ(document->head(), head);
      auto loaded = document->load();
      ASSERT_TRUE(loaded.ok()) << loaded.error();
      model = std::move(loaded).value();
      const StepId any =
          std::next(truth.begin(), random.integer(0, static_cast<int>(truth.size()) - 1))->first;
      const auto bodies = document->load_bodies(any);
      ASSERT_TRUE(bodies.ok()) << bodies.error();
      ASSERT_EQ(truth_of(bodies.value()).list, truth[any].list);
    }
  }
  EXPECT_GT(acted, 0);
  EXPECT_GT(largest, 1u);
  EXPECT_EQ(wrongs(*document), std::vector<std::string>());
  // A copy also has everything.
  ASSERT_TRUE(document->save_copy(folder / "b.kibori").ok());
  const auto copy = opened(folder / "b.kibori", Document::Access::read);
  ASSERT_NE(copy, nullptr);
  for (const auto& [step, known] : truth)
    EXPECT_EQ(truth_of(copy->load_bodies(step).value()).list, known.list) << step;
}

// If a control point is moved later, the result is the same as if it had been there from the start.
// This also holds after further actions.
TEST(DocumentBodies, WhatIsRevisedIsAsIfItHadBeenSoAtFirst) {
  Random random;
  SCOPED_TRACE(random.note());
  Folder folder;
  int revised = 0;
  for (int round = 0; round < rounds_of("KIBORI_REVISE", 15); round++) {
    BodySpline how{any_spline(random)};
    how.operation = random.integer(0, 1) ? SplineOperation::deposit : SplineOperation::cut;
    const BodyAction first{{1}, how};
    how.shape.curve.points_mm[2] +=
        Vec3(0.4, 0, how.shape.kind == SplineKind::extrude ? 0 : random.uniform(-1, 1));
    const BodyAction other{{1}, how};
    std::vector<BodyAction> later;
    for (int i = 0; i < 3; i++) later.push_back(any_action(random, BodyList::of(stock(1.5))));
    const unsigned seed = random.seed() + static_cast<unsigned>(round);
    uint64_t hashes[2] = {};
    int counts[2] = {};
    bool possible = true;
    for (const bool fresh : {false, true}) {
      const std::string name = std::to_string(round) + (fresh ? "f" : "r") + ".kibori";
      TriDexel model = stock(1.5);
      auto document = created(folder / name.c_str(), model);
      Random same(seed);
      carve(*document, model, same, 8, true, Crumbs::sort);
      if (!document->act(fresh ? other : first)) {
        possible = false;
        break;
      }
      const StepId spline = document->head();
      for (int i = 0; i < 3; i++) {
        ASSERT_TRUE(document->choose(document->bodies_at(document->head()).all.front().id).ok());
        ASSERT_TRUE(document->go(model, document->head()).ok());
        if (!document->bodies_at(document->head()).all.front().kept())
          carve(*document, model, same, 8, true, Crumbs::sort);
        counts[fresh] += document->act(later[static_cast<size_t>(i)]).ok();
      }
      if (!fresh) {
        const StepId head = document->head();
        const size_t before = document->steps().size();
        const Status done = document->revise(spline, other);
        possible = done.ok();
        if (done) {
          EXPECT_EQ(document->steps().size(), 2 * before - 2);
        } else {
          EXPECT_EQ(document->head(), head) << done.error();
        }
        ASSERT_TRUE(document->go(model, document->head()).ok());
        EXPECT_EQ(model.content_hash(),
                  document->worked_on()->find(document->active())->model.content_hash());
        EXPECT_EQ(wrongs(*document), std::vector<std::string>());
        EXPECT_FALSE(document->revise(2, other).ok());
        EXPECT_FALSE(document->revise(9999, other).ok());
      }
      hashes[fresh] = document->steps().at(document->head()).hash;
    }
    // A later action may be possible in one of the two documents and refused in the other. Then
    // they cannot be compared.
    if (!possible || counts[0] != counts[1]) continue;
    EXPECT_EQ(hashes[0], hashes[1]) << round;
    revised++;
  }
  EXPECT_GT(revised, rounds_of("KIBORI_REVISE", 15) / 5);
}

// After a kill at any moment, the bodies are complete: either those before the split, or both
// bodies after it.
TEST(DocumentBodies, AKillAmidASplitLeavesWholeBodies) {
  Random random;
  SCOPED_TRACE(random.note());
  Folder folder;
  const int kills = rounds_of("KIBORI_KILLS", 12);
  size_t largest = 0;
  for (int round = 0; round < kills; round++) {
    const auto file = folder / "k.kibori", log = folder / "told";
    for (const char* end : {"", "-wal", "-shm"})
      std::filesystem::remove(folder.path / (std::string("k.kibori") + end));
    std::filesystem::remove(log);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      TriDexel model = stock();
      auto made = Document::create(file, model, "{}");
      if (!made) _exit(1);
      std::ofstream reported(log, std::ios::binary);
      for (int i = 1; i < 30; i++) {
        const CutPlane plane{Vec3(40.0 * i / 30, 15, 10), Vec3(1, 0.1, 0.05)};
        if (!made.value()->act({{}, BodyCut{{plane}}})) _exit(1);
        reported.put('s');
        reported.flush();
      }
      _exit(0);
    }
    // Kills after a random number of reported splits and part of the next one. So the speed of the
    // machine does not matter.
    const auto splits = static_cast<std::uintmax_t>(random.integer(0, 10));
    const auto reported_now = [&] {
      std::error_code none;
      return std::filesystem::exists(log) ? std::filesystem::file_size(log, none) : 0;
    };
    for (int wait = 0; wait < 60000 && reported_now() < splits; wait++)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::microseconds(random.integer(0, 20000)));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    if (!std::filesystem::exists(file)) continue;
    const auto reported = reported_now();
    auto document = opened(file);
    ASSERT_NE(document, nullptr);
    auto model = document->load();
    ASSERT_TRUE(model.ok()) << model.error();
    const BodyList& bodies = *document->worked_on();
    EXPECT_GE(bodies.all.size(), reported + 1);
    EXPECT_LE(bodies.all.size(), reported + 2);
    EXPECT_EQ(document->steps().size(), bodies.all.size());
    EXPECT_NEAR(bodies.volume_mm3(), 40 * 30 * 20, 1e-6 * 40 * 30 * 20);
    for (const Body& body : bodies.all) EXPECT_EQ(broken(extract_surface(body.model)), "");
    EXPECT_EQ(wrongs(*document), std::vector<std::string>());
    largest = std::max(largest, bodies.all.size());
    // The document can still be carved.
    carve(*document, *model.value(), random, 5, true, Crumbs::sort);
    EXPECT_EQ(wrongs(*document), std::vector<std::string>());
  }
  EXPECT_GT(largest, 1u);
}

TEST(DocumentBodies, RowsOfOtherDataAreReported) {
  Folder folder;
  TriDexel model = stock();
  {
    auto document = created(folder / "a.kibori", model);
    const BodyAction split{{}, BodyCut{{CutPlane{Vec3(20, 15, 10), Vec3::UnitX()}}}};
    ASSERT_TRUE(document->act(split).ok());
  }
  const char* const kChanges[] = {
      "UPDATE bodies SET json = '{\"next\":3,\"bodies\":[]}' WHERE step = 2",
      "UPDATE bodies SET json = 'nonsense' WHERE step = 2",
      "UPDATE bodies SET json = replace(json, '\"Body 2\"', '\"Body 9\"') WHERE step = 2",
      "UPDATE bodies SET json = replace(json, '\"id\":2', '\"id\":1') WHERE step = 2",
      "DELETE FROM bodies WHERE step = 2",
      "UPDATE setting SET json = replace(json, '20', '21')",
      "UPDATE setting SET json = '{}'",
      "UPDATE step SET kind = 'stroke' WHERE id = 2",
  };
  for (const char* const change : kChanges) {
    std::filesystem::copy_file(folder / "a.kibori", folder / "b.kibori",
                               std::filesystem::copy_options::overwrite_existing);
    {
      auto database = Database::open(folder / "b.kibori", Database::Access::write);
      ASSERT_TRUE(database.ok()) << database.error();
      const Status changed = database.value().run(change);
      ASSERT_TRUE(changed.ok()) << changed.error();
    }
    auto document = Document::open(folder / "b.kibori", Document::Access::read);
    if (!document) {
      EXPECT_NE(document.error().find("b.kibori"), std::string::npos) << change;
      continue;
    }
    EXPECT_FALSE(wrongs(*document.value()).empty()) << change;
  }
}

// ---- A hand

// A body is split, the portion is turned and moved away, and a device carves it there. The strokes
// are stored in the portion's own coordinates and can be replayed. The force is in world
// coordinates.
TEST(DocumentBodies, AHandWorksOnAMovedBody) {
  Folder folder;
  const auto file = folder / "h.kibori";
  auto model = std::make_unique<TriDexel>(stock());
  auto document = created(file, *model);
  LiveSettings settings;
  settings.tool = BallTool{3};
  settings.log = settings.watched = true;
  settings.idle_s = 0.02;
  settings.model = ForceModel::energy;
  VirtualDeviceSettings device;
  device.capabilities.dof_in = 3;
  device.capabilities.dof_out = 3;
  // Over the portion at its final pose, and down into it.
  const Vec3 away(0, 60, 5);
  const Mat3 turn = rotation(Vec3(0, 0, std::numbers::pi / 2));
  double depth = 10;  // above its top: [mm]
  const auto target = [&](double t) -> VirtualDevice::Target {
    return {Vec3(away + turn * Vec3(30, 15, 20) + Vec3(0, 4 * std::sin(20 * t), depth)),
            Mat3::Identity(), 0};
  };
  auto made = LiveCarving::make(std::move(model), std::make_unique<VirtualDevice>(device, target),
                                settings);
  ASSERT_TRUE(made.ok()) << made.error();
  LiveCarving& live = *made.value();
  DocumentWriter writer(live, std::move(document), true);
  live.context().safety().arm();
  const auto run = [&](int ticks) {
    for (int i = 0; i < ticks; i++) {
      live.tick(0.001);
      if (i % 5 == 0) writer.write();
    }
  };
  const auto settle = [&] {
    for (int i = 0; i < 400 && !writer.idle(); i++) run(5);
    ASSERT_TRUE(writer.idle());
  };
  const BodyAction split{{}, BodyCut{{CutPlane{Vec3(20, 15, 10), Vec3::UnitX()}}}};
  writer.act(split);
  settle();
  writer.act({{2}, BodyMove{{away, turn}}});
  writer.choose(2);
  settle();
  EXPECT_EQ(writer.notice(), "");
  EXPECT_EQ(writer.document().active(), 2);
  run(200);
  EXPECT_EQ(writer.document().steps().size(), 3u) << "nothing was touched";
  depth = -2;
  LiveTick tick;
  double up = 0, removed = 0;
  for (int i = 0; i < 300; i++) {
    run(1);
    while (live.next_tick(tick)) {
      up = std::max(up, tick.computed.force.z());
      removed += tick.removed_mm3;
    }
  }
  depth = 10;
  run(200);
  live.context().finish_stroke();
  writer.write();
  EXPECT_GT(removed, 20);
  EXPECT_GT(up, 0) << "the wood pushes up";
  EXPECT_GT(tick.tool.tip.y(), 40) << "ticks tell where the tool is in the world";
  Document& kept = writer.document();
  const BodyList& bodies = *kept.worked_on();
  ASSERT_EQ(bodies.all.size(), 2u);
  EXPECT_NEAR(bodies.all[0].model.volume_mm3(), 12000, 1e-3);
  EXPECT_NEAR(bodies.all[1].model.volume_mm3(), 12000 - removed, 1e-3);
  EXPECT_EQ(wrongs(kept), std::vector<std::string>());
  // A locked body gives a force and does not change.
  BodySet lock;
  lock.properties.locked = true;
  writer.act({{2}, lock});
  settle();
  const uint64_t hash = live.context().model().content_hash();
  depth = -4;
  run(300);
  double pushed = 0;
  while (live.next_tick(tick)) pushed = std::max(pushed, tick.computed.force.z());
  EXPECT_EQ(live.context().model().content_hash(), hash);
  EXPECT_GT(pushed, 0);
  // An impossible action is reported, and the hand continues.
  writer.act({{2, 7}, BodyJoin{}});
  settle();
  EXPECT_NE(writer.notice().find("7"), std::string::npos);
}

// A stroke severs its body. The portion exists as soon as the stroke does, and one undo restores
// both. A hand that continues meanwhile only gets a force.
TEST(DocumentBodies, SeveredPiecesOfAStrokeFallOff) {
  Folder folder;
  for (const Crumbs rule : kRules) {
    const auto file = folder.path / (std::string(name_of(rule)) + ".kibori");
    auto model = std::make_unique<TriDexel>(stock());
    auto document = created(file, *model);
    LiveSettings settings;
    settings.tool = Flat{1.5, 40};
    settings.log = settings.watched = true;
    settings.idle_s = 0.02;
    settings.model = ForceModel::energy;
    settings.crumbs = rule;
    VirtualDeviceSettings device;
    device.capabilities.dof_in = 3;
    // Across the block at x = 12.5, through its whole height.
    const auto target = [](double t) -> VirtualDevice::Target {
      return {Vec3(12.5, std::min(-6 + 80 * t, 36.0), -2), Mat3::Identity(), 0};
    };
    auto made = LiveCarving::make(std::move(model), std::make_unique<VirtualDevice>(device, target),
                                  settings);
    ASSERT_TRUE(made.ok()) << made.error();
    LiveCarving& live = *made.value();
    DocumentWriter writer(live, std::move(document));
    int parted = 0;
    double fallen = 0;
    for (int i = 0; i < 700; i++) {
      const LiveTick tick = live.tick(0.001);
      parted += tick.parted;
      fallen += tick.fallen_mm3;
      if (i % 10 == 0) writer.write();
    }
    live.context().finish_stroke();
    writer.write();
    Document& kept = writer.document();
    ASSERT_EQ(kept.steps().size(), 2u);
    const BodyList& bodies = *kept.worked_on();
    // The portion is a quarter of the block, so it is too large to be a crumb.
    const bool apart = rule == Crumbs::sort || rule == Crumbs::body;
    EXPECT_EQ(bodies.all.size(), apart ? 2u : 1u) << name_of(rule);
    EXPECT_EQ(parted, apart ? 1 : 0);
    EXPECT_NEAR(fallen, rule == Crumbs::fall ? 11 * 30 * 20 : 0, 1);
    EXPECT_EQ(live.context().model().content_hash(), bodies.all[0].model.content_hash());
    EXPECT_NEAR(bodies.all[0].model.volume_mm3(), (rule == Crumbs::stay ? 37 : 26) * 30 * 20, 1);
    if (apart) {
      EXPECT_NEAR(bodies.all[1].model.volume_mm3(), 11 * 30 * 20, 1);
    }
    EXPECT_EQ(wrongs(kept), std::vector<std::string>());
    writer.undo();
    for (int i = 0; i < 2000 && !writer.idle(); i++) {
      live.tick(0.001);
      writer.write();
    }
    EXPECT_EQ(kept.worked_on()->all.size(), 1u);
    EXPECT_NEAR(live.context().model().volume_mm3(), 40 * 30 * 20, 1e-3);
  }
}

}  // namespace
}  // namespace kibori::document_bodies_tests
