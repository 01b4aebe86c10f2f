// SPDX-License-Identifier: MIT
// Documents: the stored data equals the recorded work. The history is compared with a simple oracle
// that keeps full copies.
#include <array>
#include <bit>
#include <fstream>
#include <filesystem>

#include <gtest/gtest.h>

#include <kibori/document/codec.h>
#include <kibori/document/database.h>
#include <kibori/document/document.h>
#include <kibori/motion/direct_tool.h>

#include "tests/document_support.h"
#include "tests/plain_material.h"

namespace kibori::document_tests {
namespace {

using namespace test;

TEST(Codec, SettingsOfEveryToolRoundTrip) {
  Random random;
  for (size_t shape = 0; shape < kToolShapes.size(); shape++) {
    const Tool tool = random_tool(shape, random, {0.1, 9, 1, 30});
    StrokeSettings s;
    s.tool = tool;
    s.mode = Mode::touch;
    Material oak = test::plain_material("oak \"a\"", 0.1, 1.0 / 7, 1e-5, 0.3);
    oak.color = {1, 2, 255};
    oak.gc = 0.2;
    oak.u_along = 1.0 / 9;
    oak.ring = 0.7;
    Material ash = test::plain_material("ash", 0.1, 1.0 / 7);
    ash.k = {30.0 / 7, 2, 1.0 / 3};
    ash.m = 1.0 / 3;
    ash.density_kg_m3 = 691.1;
    ash.log = {1.0 / 3, Vec3(1.0 / 3, 2, 3), Vec3(-1, 0.1, 5)};
    s.materials = {Material{}, oak, ash};
    s.material = 1;
    s.rate_hz = 2000;
    s.force.spring = {1.5, 20, 0.1, 1.0 / 2000};
    s.force.law = {tool.index() % 2 ? ForceModel::series : ForceModel::energy, 6};
    const auto back = settings_from_json(settings_to_json(s));
    ASSERT_TRUE(back.ok()) << back.error();
    const StrokeSettings& b = back.value();
    if (const auto* m = std::get_if<MeshTool>(&tool)) {
      EXPECT_EQ(std::get<MeshTool>(b.tool).mesh->vertices, m->mesh->vertices);
      EXPECT_EQ(std::get<MeshTool>(b.tool).mesh->triangles, m->mesh->triangles);
    } else {
      EXPECT_TRUE(b.tool == tool);
    }
    EXPECT_EQ(settings_to_json(b), settings_to_json(s));
    EXPECT_EQ(b.mode, s.mode);
    EXPECT_EQ(b.materials[1].u, 1.0 / 7);
    EXPECT_EQ(b.force.law.model, s.force.law.model);
    EXPECT_EQ(b.force.spring.stiffness_n_mm,
              s.force.series() ? 1.5 : SeriesSpring{}.stiffness_n_mm);
  }
  for (const Mode mode : {Mode::smooth, Mode::rasp, Mode::fill, Mode::inflate, Mode::flatten}) {
    StrokeSettings s;
    s.mode = mode;
    s.brush = {1.0 / 3,
               mode == Mode::inflate ? -0.7 : 0.7,
               Falloff::linear,
               0.1,
               true,
               mode == Mode::flatten ? FlattenTo::plane : FlattenTo::dab,
               {Vec3(1, 2, 1.0 / 7), Vec3(0, 0.6, 0.8)}};
    s.brush.wall_mm = 1.5;
    s.brush.spacing = 0.75;
    const auto back = settings_from_json(settings_to_json(s));
    ASSERT_TRUE(back.ok()) << back.error();
    const Brush& b = back.value().brush;
    EXPECT_EQ(back.value().mode, mode);
    EXPECT_EQ(b.radius_mm, 1.0 / 3);
    EXPECT_EQ(b.strength, s.brush.strength);
    EXPECT_EQ(b.falloff, Falloff::linear);
    EXPECT_EQ(b.sigma_mm, 0.1);
    EXPECT_TRUE(b.keep_volume);
    EXPECT_EQ(b.flatten_to, s.brush.flatten_to);
    EXPECT_EQ(b.wall_mm, 1.5);
    EXPECT_EQ(b.spacing, 0.75);
    if (mode == Mode::flatten) {
      EXPECT_EQ(b.plane.point_mm, s.brush.plane.point_mm);
      EXPECT_EQ(b.plane.normal, s.brush.plane.normal);
    }
    const std::string good = settings_to_json(s);
    for (const auto& [what, with] : {std::pair{"\"radius_mm\":0.33", "\"radius_mm\":-0.33"},
                                     {"\"falloff\":\"linear\"", "\"falloff\":\"steep\""},
                                     {"\"sigma_mm\":0.1", "\"sigma_mm\":1e999"},
                                     {"\"keep_volume\":true", "\"keep_volume\":1"},
                                     {"\"spacing\":0.75", "\"spacing\":0.0"},
                                     {"\"wall_mm\":1.5", "\"wall_mm\":\"thick\""},
                                     {"\"brush\":{", "\"brush\":7,\"x\":{"}}) {
      std::string bad = good;
      ASSERT_NE(bad.find(what), std::string::npos) << what << " in " << good;
      bad.replace(bad.find(what), std::string_view(what).size(), with);
      EXPECT_FALSE(settings_from_json(bad).ok()) << bad;
    }
  }
  for (const char* bad :
       {"", "[]", "{}", R"({"tool":{"shape":"ball","radius":-1}})", R"({"tool":{"shape":"spoon"}})",
        R"({"tool":{"shape":"ball","radius":1},"mode":"cut","rate_hz":0})",
        R"({"tool":{"shape":"mesh","vertices":[[0,0,0]],"triangles":[[0,1,2]]}})"})
    EXPECT_FALSE(settings_from_json(bad).ok()) << bad;
}

std::array<uint64_t, 3> bits_of(const Vec3& v) {
  return {std::bit_cast<uint64_t>(v.x()), std::bit_cast<uint64_t>(v.y()),
          std::bit_cast<uint64_t>(v.z())};
}

TEST(Codec, TicksRoundTripBitForBit) {
  Random random;
  for (const size_t count : {0u, 1u, 2u, 50u, 3000u}) {
    std::vector<RecordedTick> ticks(count);
    for (RecordedTick& tick : ticks) {
      MoveTick move;
      move.tip = random.in_box(-1e3, 1e3);
      move.stretch_mm = random.in_box(-1, 1) * std::pow(10, random.uniform(-300, 10));
      if (random.integer(0, 1)) move.turn = Vec3(-0.0, 5e-324, 1);
      move.edits = random.integer(0, 1);
      move.computes = random.integer(0, 1);
      if (count != 50 && random.integer(0, 1)) move.pressure = random.uniform(0, 1);
      tick.what = move;
      tick.second = random.integer(0, 3) == 0;
      if (random.integer(0, 9) == 0)
        tick.what = PutTick{{move.tip, frame_from_axis(random.direction(), 0)}};
      if (random.integer(0, 9) == 0) tick = {EndTick{move.tip}, false};
      // A milled stroke: most ticks have a line.
      if (count != 50 && random.integer(0, 3)) tick.line = random.integer(1, 2000000000);
    }
    const auto back = decode_ticks(encode_ticks(ticks.data(), count));
    ASSERT_TRUE(back.ok());
    ASSERT_EQ(back.value().size(), count);
    for (size_t i = 0; i < count; i++) {
      const RecordedTick &was = ticks[i], &is = back.value()[i];
      ASSERT_EQ(is.what.index(), was.what.index()) << random.note();
      EXPECT_EQ(is.second, was.second);
      EXPECT_EQ(is.line, was.line);
      EXPECT_EQ(bits_of(tip_of(is)), bits_of(tip_of(was)));
      if (const auto* const move = std::get_if<MoveTick>(&was.what)) {
        const auto& read = std::get<MoveTick>(is.what);
        EXPECT_EQ(bits_of(read.turn), bits_of(move->turn));
        EXPECT_EQ(bits_of(read.stretch_mm), bits_of(move->stretch_mm));
        EXPECT_EQ(read.edits, move->edits);
        EXPECT_EQ(read.computes, move->computes);
        EXPECT_EQ(read.pressure, move->pressure);
      } else if (const auto* const put = std::get_if<PutTick>(&was.what)) {
        for (int c = 0; c < 3; c++)
          EXPECT_EQ(bits_of(std::get<PutTick>(is.what).pose.frame.col(c)),
                    bits_of(put->pose.frame.col(c)));
      }
    }
  }
}

TEST(Codec, ATickWithAnImpossiblePressureIsRefused) {
  for (const double pressure : {-0.1, 1.5}) {
    MoveTick move;
    move.pressure = pressure;
    const RecordedTick tick{move};
    EXPECT_FALSE(is_finite(tick));
    EXPECT_FALSE(decode_ticks(encode_ticks(&tick, 1)).ok());
  }
}

// The picture of a brush is stored with the stroke's settings.
TEST(Codec, ABrushKeepsItsPictureAndItsUseOfPressure) {
  Random random;
  StrokeSettings settings;
  settings.mode = Mode::inflate;
  settings.brush.pressure = PressureUse::both;
  settings.brush.alpha = Alpha::picture;
  auto picture = std::make_shared<AlphaPicture>();
  for (uint8_t& grey : picture->greys) grey = static_cast<uint8_t>(random.integer(0, 255));
  settings.brush.picture = picture;
  const std::string text = settings_to_json(settings);
  const auto back = settings_from_json(text);
  ASSERT_TRUE(back.ok()) << back.error();
  EXPECT_EQ(back.value().brush.pressure, PressureUse::both);
  ASSERT_TRUE(back.value().brush.picture);
  EXPECT_TRUE(*back.value().brush.picture == *picture);
  // A damaged one is refused.
  for (const auto& [key, with] : {std::pair{"\"picture\":\"", "\"picture\":\"0"},
                                  {"\"picture\":\"", "\"picture\":\"zz"},
                                  {"\"picture\":\"", "\"image\":\""},
                                  {"\"pressure\":\"both\"", "\"pressure\":\"all\""}}) {
    std::string bad = text;
    bad.replace(bad.find(key), std::string_view(key).size(), with);
    EXPECT_FALSE(settings_from_json(bad).ok()) << with;
  }
}

// History against full copies.
TEST(Document, UndoRedoAndBranchesAgainstFullCopies) {
  Random random;
  Folder folder;
  const int steps = rounds_of("KIBORI_HISTORY", 600);
  auto model = std::make_unique<TriDexel>(stock());
  auto document = created(folder / "a.kibori", *model);
  std::map<StepId, uint64_t> truth{{1, model->content_hash()}};
  std::vector<StepId> undone;  // undone steps, in order
  std::map<StepId, StepId> parent;
  for (int i = 0; i < steps; i++) {
    enum Action { kStroke, kUndo, kRedo, kGo, kCancelledStroke };
    constexpr Action kMix[] = {kStroke, kStroke, kStroke, kStroke, kUndo,
                               kUndo,   kRedo,   kRedo,   kGo,     kCancelledStroke};
    const Action action = kMix[random.integer(0, 9)];
    if (action == kStroke) {
      const StepId before = document->head();
      carve(*document, *model, random, random.integer(1, 20));
      truth[document->head()] = model->content_hash();
      parent[document->head()] = before;
    } else if (action == kUndo) {
      const StepId at = document->head();
      const Status done = document->undo(*model);
      ASSERT_EQ(done.ok(), at != 1);
      if (done) {
        ASSERT_EQ(document->head(), parent[at]);
      }
    } else if (action == kRedo) {
      const StepId at = document->head();
      const bool any =
          std::any_of(parent.begin(), parent.end(), [&](const auto& p) { return p.second == at; });
      ASSERT_EQ(document->redo(*model).ok(), any);
      if (any) {
        ASSERT_EQ(parent[document->head()], at);
      }
    } else if (action == kGo) {
      const StepId to =
          std::next(truth.begin(), random.integer(0, static_cast<int>(truth.size()) - 1))->first;
      ASSERT_TRUE(document->go(*model, to).ok());
      ASSERT_EQ(document->head(), to);
    } else {
      // Cancels a stroke in the middle.
      carve(*document, *model, random, 5, false);
      ASSERT_TRUE(document->cancel().ok());
      ASSERT_TRUE(document->go(*model, document->head()).ok());
    }
    ASSERT_EQ(model->content_hash(), truth[document->head()]) << i << random.note();
    if (i % 100 == 99) {
      // After closing and reopening, the document is the same. It can go to any step with nothing
      // in memory.
      const StepId head = document->head();
      document.reset();
      document = opened(folder / "a.kibori");
      ASSERT_NE(document, nullptr);
      ASSERT_EQ(document->head(), head);
      auto loaded = document->load();
      ASSERT_TRUE(loaded.ok()) << loaded.error();
      model = std::move(loaded).value();
      ASSERT_EQ(model->content_hash(), truth[head]) << random.note();
      ASSERT_EQ(document->steps().size(), truth.size());
    }
  }
  for (const auto& [step, hash] : truth) EXPECT_EQ(document->steps().at(step).hash, hash);
  EXPECT_EQ(wrongs(*document), std::vector<std::string>());
}

// After enough time, every step has stored tiles, so no path needs the replay of a stroke. Here a
// replay would fail, because the test deletes the ticks.
TEST(Document, AnyStepIsReachedByTiles) {
  Random random;
  Folder folder;
  std::map<StepId, uint64_t> truth;
  TriDexel model = stock();
  {
    auto document = created(folder / "t.kibori", model);
    truth[1] = model.content_hash();
    for (int i = 0; i < 150; i++) {
      carve(*document, model, random, 5);
      truth[document->head()] = model.content_hash();
      if (i % 30 != 29) continue;
      ASSERT_TRUE(document->go(model, random.integer(1, i + 1)).ok());
    }
  }
  auto database = Database::open(folder / "t.kibori", Database::Access::write);
  ASSERT_TRUE(database.ok() && database.value().run("DELETE FROM tick").ok());
  database = Database();
  auto document = opened(folder / "t.kibori");
  auto loaded = document->load();
  ASSERT_TRUE(loaded.ok()) << loaded.error();
  TriDexel& live = *loaded.value();
  for (int i = 0; i < 300; i++) {
    const StepId step = i < 100 ? std::max<StepId>(1, document->steps().at(document->head()).parent)
                                : random.integer(1, static_cast<int>(truth.size()));
    const Status result = document->go(live, step);
    ASSERT_TRUE(result.ok()) << result.error();
    ASSERT_EQ(live.content_hash(), truth[step]) << step << random.note();
  }
}

// A deposit beyond all earlier material, and a cut by a tall tool through it. Both have no tiles
// and are on another branch than the head. The known bounds of the material must grow on the path.
TEST(Document, FillsAreReplayedOnACopy) {
  Folder folder;
  const auto file = folder / "b.kibori";
  {
    TriDexel model(make_lattice(Vec3(40, 30, 20), 1, 12).value());
    model.fill_block({Vec3::Zero(), Vec3(40, 30, 20)}, 0);
    auto document = created(file, model);
    for (const bool fill : {true, false}) {
      StrokeSettings s;
      s.tool = fill ? Tool(BallTool{4}) : Tool(Flat{2, 60});
      s.mode = fill ? Mode::deposit : Mode::cut;
      const Pose start{Vec3(5, 15, fill ? 23 : 12), Mat3::Identity()};
      ASSERT_TRUE(document->begin(s, start).ok());
      DirectTool stroke(model, start);
      for (int i = 0; i < 40; i++) {
        MoveTick tick;
        tick.tip = stroke.pose().tip + Vec3(0.5, 0, 0);
        tick.edits = true;
        ASSERT_TRUE(
            stroke.advance(s.tool, tick.tip, tick.turn, s.mode, s.force.law, s.materials).ok());
        document->add({tick});
      }
      ASSERT_TRUE(document->finish(model, 0).ok());
    }
  }
  auto database = Database::open(file, Database::Access::write);
  ASSERT_TRUE(database.ok() &&
              database.value()
                  .run("DELETE FROM checkpoint_tile WHERE step > 1; DELETE FROM checkpoint "
                       "WHERE step > 1; UPDATE meta SET value = 1 WHERE key = 'head'")
                  .ok());
  database = Database();
  for (const bool elsewhere : {true, false}) {
    auto document = opened(file, Document::Access::read);
    auto model = document->load();
    ASSERT_TRUE(model.ok()) << model.error();
    TriDexel& live = *model.value();
    for (const StepId step : {2, 3, 2, 1, 3}) {
      if (elsewhere) {
        auto to = document->checkout(step);
        ASSERT_TRUE(to.ok()) << to.error();
        live.include_material(to.value().material_bounds);
        live.restore(to.value().state);
        ASSERT_TRUE(document->commit_checkout(to.value()).ok());
      } else {
        ASSERT_TRUE(document->go(live, step).ok());
      }
      EXPECT_EQ(live.content_hash(), document->steps().at(step).hash) << step;
    }
    ASSERT_TRUE(document->go(live, 1).ok());
  }
}

// Rows of tiles that belong to no step, to a step without tiles, or to no place: ignored or
// reported.
TEST(Document, TilesOfNoStep) {
  Random random;
  for (const char* const harm :
       {"PRAGMA foreign_keys = OFF; INSERT INTO checkpoint_tile SELECT -1, field, "
        "u, v, NULL FROM checkpoint_tile WHERE "
        "step = 5",
        "PRAGMA foreign_keys = OFF; INSERT INTO checkpoint_tile SELECT 0, field, u, "
        "v, NULL FROM checkpoint_tile WHERE step "
        "= 5",
        "PRAGMA foreign_keys = OFF; DELETE FROM checkpoint WHERE step = 7",
        "UPDATE checkpoint SET bounds = 'x' WHERE step = 4"}) {
    Folder folder;
    {
      TriDexel model = stock();
      auto document = created(folder / "h.kibori", model);
      for (int i = 0; i < 6; i++) carve(*document, model, random, 10);
    }
    auto database = Database::open(folder / "h.kibori", Database::Access::write);
    ASSERT_TRUE(database.ok());
    const Status harmed = database.value().run(harm);
    ASSERT_TRUE(harmed.ok()) << harmed.error();
    database = Database();
    auto document = Document::open(folder / "h.kibori", Document::Access::write);
    if (std::string_view(harm).find("bounds") != std::string_view::npos) {
      EXPECT_FALSE(document.ok());
      continue;
    }
    ASSERT_TRUE(document.ok()) << document.error();
    auto model = document.value()->load();
    ASSERT_TRUE(model.ok()) << model.error();
    for (const StepId step : {7, 6, 5, 4, 1, 3}) {
      EXPECT_TRUE(document.value()->go(*model.value(), step).ok());
      EXPECT_EQ(model.value()->content_hash(), document.value()->steps().at(step).hash)
          << harm << " " << step;
    }
    EXPECT_TRUE(document.value()->flush().ok());
    carve(*document.value(), *model.value(), random, 10);
    EXPECT_TRUE(document.value()->flush().ok());
    EXPECT_TRUE(document.value()->move_to(folder / "elsewhere.kibori").ok());
  }
}

// Only another thread may change the model. So checkout() makes a state, the caller restores it,
// and commit_checkout() then moves the document's head.
TEST(Document, DestinationsForAModelElsewhere) {
  Random random;
  Folder folder;
  std::map<StepId, uint64_t> truth;
  {
    TriDexel model = stock();
    auto document = created(folder / "d.kibori", model);
    for (int i = 0; i < 200; i++) {
      truth[document->head()] = model.content_hash();
      carve(*document, model, random, 3);
      if (i % 40 != 0) continue;
      truth[document->head()] = model.content_hash();
      wander(*document, model);
    }
    truth[document->head()] = model.content_hash();
  }
  auto document = opened(folder / "d.kibori");
  EXPECT_FALSE(document->checkout(5).ok()) << "there is no model yet";
  auto model = document->load();
  ASSERT_TRUE(model.ok());
  TriDexel& live = *model.value();
  const auto go = [&](StepId step) {
    auto to = document->checkout(step);
    ASSERT_TRUE(to.ok()) << to.error();
    // The document made the state in its own memory. The live model can still restore it.
    EXPECT_TRUE(to.value().state.of_same_model(live.snapshot()));
    live.restore(to.value().state);
    ASSERT_TRUE(document->commit_checkout(to.value()).ok());
    EXPECT_EQ(live.content_hash(), truth[step]) << step;
  };
  for (const StepId step :
       {StepId{206}, StepId{205}, StepId{5}, StepId{1}, StepId{190}, StepId{204}})
    go(step);
  for (int i = 0; i < 300; i++) go(random.integer(1, 206));
  // Adds a step carved from the live model, and one carved from another model. A later checkout
  // must not mix the states of the two models.
  go(190);
  TriDexel other = stock();
  carve(*document, live, random, 3);
  const StepId fresh = document->head();
  truth[fresh] = live.content_hash();
  carve(*document, other, random, 3);
  go(fresh);
  go(190);
  EXPECT_FALSE(document->checkout(4711).ok());
}

TEST(Document, ForcesAreStoredOnRequestAndVerified) {
  Random random;
  Folder folder;
  TriDexel model = stock();
  auto document = created(folder / "f.kibori", model);
  StrokeSettings s;
  s.tool = BallTool{3};
  const Pose start{Vec3(5, 10, 18), Mat3::Identity()};
  std::vector<Wrench> computed;
  ASSERT_TRUE(document->begin(s, start).ok());
  DirectTool stroke(model, start);
  for (int i = 0; i < 40; i++) {
    MoveTick tick;
    tick.tip = stroke.pose().tip + Vec3(0.7, 0, -0.05);
    tick.edits = true;
    const auto done = stroke.advance(s.tool, tick.tip, tick.turn, s.mode, s.force.law, s.materials);
    ASSERT_TRUE(done.ok());
    computed.push_back(done.value().wrench);
    document->add({tick}, &computed.back());
    if (i % 16 == 15) {
      ASSERT_TRUE(document->flush().ok());
    }
  }
  ASSERT_TRUE(document->finish(model, 1).ok());
  carve(*document, model, random, 5);
  document.reset();
  document = opened(folder / "f.kibori", Document::Access::read);
  const auto read = [&](StepId step) {
    std::vector<Wrench> kept;
    EXPECT_TRUE(document
                    ->for_forces(step,
                                 [&](const std::vector<Wrench>& block) -> Status {
                                   kept.insert(kept.end(), block.begin(), block.end());
                                   return Ok{};
                                 })
                    .ok());
    return kept;
  };
  const std::vector<Wrench> kept = read(2);
  ASSERT_EQ(kept.size(), computed.size());
  double max = 0;
  for (size_t i = 0; i < kept.size(); i++) {
    EXPECT_EQ(kept[i].force, computed[i].force);
    EXPECT_EQ(kept[i].moment, computed[i].moment);
    max = std::max(max, kept[i].force.squaredNorm());
  }
  EXPECT_GT(max, 0);
  EXPECT_TRUE(read(3).empty());
  EXPECT_EQ(wrongs(*document), std::vector<std::string>());
  document.reset();
  // Changed forces are reported.
  computed[20].force.x() += 1e-9;
  {
    auto database = Database::open(folder / "f.kibori", Database::Access::write);
    ASSERT_TRUE(database.ok());
    auto change =
        database.value().prepare("UPDATE force SET data = ?, count = 40 WHERE sequence = 0");
    ASSERT_TRUE(change.value().bind(encode_forces(computed.data(), computed.size())).run().ok());
    ASSERT_TRUE(database.value().run("DELETE FROM force WHERE sequence > 0").ok());
  }
  document = opened(folder / "f.kibori", Document::Access::read);
  const auto reported = wrongs(*document);
  ASSERT_EQ(reported.size(), 2u);
  EXPECT_NE(reported[0].find("step 2: its rows of table 'force'"), std::string::npos)
      << reported[0];
  EXPECT_NE(reported[1].find("step 2: the stored forces of 1 ticks"), std::string::npos)
      << reported[1];
}

TEST(Document, ThumbnailsAreKeptByStep) {
  Folder folder;
  TriDexel model = stock();
  auto document = created(folder / "t.kibori", model);
  EXPECT_TRUE(document->thumbnail(1).value().empty());
  EXPECT_TRUE(document->set_thumbnail(1, {1, 2, 3}).ok());
  EXPECT_TRUE(document->set_thumbnail(1, {4, 5}).ok());
  EXPECT_FALSE(document->set_thumbnail(7, {4, 5}).ok());
  document.reset();
  document = opened(folder / "t.kibori", Document::Access::read);
  EXPECT_EQ(document->thumbnail(1).value(), (Bytes{4, 5}));
  EXPECT_FALSE(document->set_thumbnail(1, {1}).ok());
}

TEST(Document, KeepsWhenStepsWereMadeAndWithWhat) {
  Folder folder;
  TriDexel model = stock();
  const auto now = [] {
    const auto since = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::seconds>(since).count();
  };
  const int64_t before = now();
  auto document = created(folder / "w.kibori", model);
  StrokeSettings s;
  for (const double radius : {2.0, 2.0, 3.0}) {
    s.tool = BallTool{radius};
    ASSERT_TRUE(document->begin(s, Pose{}, "labelled").ok());
    ASSERT_TRUE(document->finish(model, 0).ok());
  }
  EXPECT_TRUE(document->set_thumbnail(3, {1, 2, 3}).ok());
  const int64_t after = now();
  const auto as_it_was = [&](const Document& d) {
    const auto& steps = d.steps();
    ASSERT_EQ(steps.size(), 4u);
    for (const auto& [id, step] : steps) {
      EXPECT_GE(step.made_s, before) << id;
      EXPECT_LE(step.made_s, after) << id;
      EXPECT_EQ(step.pictured, id == 3) << id;
      EXPECT_EQ(step.label, id == 1 ? "" : "labelled") << id;
    }
    EXPECT_EQ(steps.at(1).setting, 0);
    EXPECT_GT(steps.at(2).setting, 0);
    EXPECT_EQ(steps.at(3).setting, steps.at(2).setting);
    EXPECT_NE(steps.at(4).setting, steps.at(2).setting);
    EXPECT_EQ(std::get<BallTool>(d.settings(4).value().tool).radius, 3);
  };
  as_it_was(*document);
  document.reset();
  as_it_was(*opened(folder / "w.kibori", Document::Access::read));
  // A step with an invalid time in the file has no known time.
  {
    auto database = Database::open(folder / "w.kibori", Database::Access::write);
    ASSERT_TRUE(database.ok());
    ASSERT_TRUE(database.value().run("UPDATE step SET made_at = 'once' WHERE id = 2").ok());
  }
  EXPECT_EQ(opened(folder / "w.kibori", Document::Access::read)->steps().at(2).made_s, 0);
}

TEST(Document, KeepsVersionsLabelsAndTheStock) {
  Random random;
  Folder folder;
  TriDexel model = stock();
  {
    auto made = Document::create(folder / "a.kibori", model, R"({"kind":"block"})", Bytes{1, 2, 3});
    ASSERT_TRUE(made.ok()) << made.error();
    carve(*made.value(), model, random, 10);
    ASSERT_TRUE(made.value()->name_version("first try", 2).ok());
    EXPECT_FALSE(made.value()->name_version("7", 2).ok());
    EXPECT_FALSE(made.value()->name_version("ghost", 99).ok());
    EXPECT_FALSE(Document::create(folder / "a.kibori", model, "{}").ok());  // it exists already
  }
  auto document = opened(folder / "a.kibori", Document::Access::read);
  ASSERT_NE(document, nullptr);
  EXPECT_EQ(document->stock().value(), R"({"kind":"block"})");
  EXPECT_EQ(document->source().value(), (Bytes{1, 2, 3}));
  EXPECT_EQ(document->find("first try").value(), 2);
  EXPECT_EQ(document->find("1").value(), 1);
  EXPECT_FALSE(document->find("none").ok());
  EXPECT_EQ(document->steps().at(2).label, "by chance");
  EXPECT_FALSE(document->begin({}, {}).ok());
}

TEST(Document, CopiesAreWholeAndIndependent) {
  Random random;
  Folder folder;
  TriDexel model = stock();
  auto document = created(folder / "a.kibori", model);
  for (int i = 0; i < 3; i++) carve(*document, model, random, 10);
  // A running stroke is copied as far as it was flushed.
  carve(*document, model, random, 14, false);
  ASSERT_TRUE(document->save_copy(folder / "b.kibori").ok());
  EXPECT_FALSE(document->save_copy(folder / "b.kibori").ok());
  EXPECT_FALSE(document->save_copy(folder / "no/such/b.kibori").ok());
  EXPECT_FALSE(std::filesystem::exists(folder / "b.kibori.part"));
  ASSERT_TRUE(document->finish(model, 0).ok());
  auto copy = opened(folder / "b.kibori");
  ASSERT_NE(copy, nullptr);
  EXPECT_EQ(wrongs(*copy), std::vector<std::string>());
  EXPECT_EQ(copy->steps().size(), 5u);
  EXPECT_EQ(copy->load().value()->content_hash(), model.content_hash());
}

// The version that the file states.
int64_t version_of(const std::filesystem::path& path) {
  Result<Database> database = Database::open(path, Database::Access::read);
  if (!database) return -1;
  Result<Statement> read = database.value().prepare("PRAGMA user_version");
  return read && read.value().row() ? read.value().integer(0) : -1;
}

TEST(Document, ReportsItsVersion) {
  Folder folder;
  TriDexel model = stock();
  created(folder / "a.kibori", model);
  EXPECT_EQ(version_of(folder / "a.kibori"), 13);
  {
    Result<Database> database = Database::open(folder / "a.kibori", Database::Access::write);
    ASSERT_TRUE(database.ok() && database.value().run("PRAGMA user_version=12").ok());
  }
  ASSERT_NE(opened(folder / "a.kibori"), nullptr);
  EXPECT_EQ(version_of(folder / "a.kibori"), 13);
}

// A document of each past version opens with the same content.
TEST(Document, OldVersionsOpen) {
  for (const auto& [name, hash, steps] :
       {std::tuple{"v1.kibori", uint64_t{0xdc65b2b1f2342f8d}, 5u},
        std::tuple{"v2.kibori", uint64_t{0xcd2533db3542f74d}, 5u},
        std::tuple{"v3.kibori", uint64_t{0xcd2533db3542f74d}, 5u},
        std::tuple{"v4.kibori", uint64_t{0xb3b36bf741014dd7}, 6u},
        std::tuple{"v5.kibori", uint64_t{0xeb6299927b11cc79}, 6u}}) {
    Folder folder;
    std::filesystem::copy(std::filesystem::path(KIBORI_SOURCE_DIR) / "tests/documents" / name,
                          folder / name);
    auto document = opened(folder / name, Document::Access::read);
    ASSERT_NE(document, nullptr);
    EXPECT_EQ(wrongs(*document), std::vector<std::string>());
    EXPECT_TRUE(document->thumbnail(1).ok());
    for (const auto& [id, step] : document->steps())
      EXPECT_GT(step.made_s, 1'700'000'000) << name << " " << id;
    // Opening it for writing upgrades it.
    document.reset();
    document = opened(folder / name);
    ASSERT_NE(document, nullptr);
    EXPECT_EQ(version_of(folder / name), 13);
    EXPECT_TRUE(document->set_thumbnail(3, {1, 2, 3}).ok());
    EXPECT_EQ(document->steps().size(), steps);
    EXPECT_EQ(wrongs(*document), std::vector<std::string>());
    const auto model = document->load();
    ASSERT_TRUE(model.ok()) << model.error();
    EXPECT_EQ(model.value()->content_hash(), hash);
    EXPECT_EQ(document->find("before the turn").value(), 3);
    for (const StepId step : {2, 5, 1, 3, 4}) {
      EXPECT_TRUE(document->go(*model.value(), step).ok());
      EXPECT_EQ(model.value()->content_hash(), document->steps().at(step).hash)
          << name << " " << step;
    }
  }
}

// In scenes with force model series, Kibori 0.1 recorded reshaping strokes as ticks that edit
// nothing. The document has a grab, a press with its end, and smoothing. The replay gives the model
// that was carved.
TEST(Document, TicksThatLostTheirEditsReplay) {
  Folder folder;
  std::filesystem::copy(
      std::filesystem::path(KIBORI_SOURCE_DIR) / "tests/documents/v12-series.kibori",
      folder / "a.kibori");
  auto document = opened(folder / "a.kibori", Document::Access::read);
  ASSERT_NE(document, nullptr);
  EXPECT_EQ(wrongs(*document), std::vector<std::string>());
  EXPECT_EQ(document->steps().at(document->head()).hash, 0x971bcbb59c8886a5u);
}

TEST(Document, AMillionTicksAtOnceAndForcesOfSome) {
  Folder folder;
  TriDexel model = stock();
  auto document = created(folder / "a.kibori", model);
  const Wrench computed, given{Vec3(1, 2, 3), Vec3(4, 5, 6)};
  ASSERT_TRUE(document->begin({}, {}).ok());
  for (int i = 0; i < 1000100; i++) document->add({});
  ASSERT_TRUE(document->finish(model, 0).ok());
  ASSERT_TRUE(document->begin({}, {}).ok());
  for (int i = 0; i < 20; i++) {
    document->add({}, i == 15 ? nullptr : &computed, &given);
    if (i % 4 == 3) {
      ASSERT_TRUE(document->flush().ok());
    }
  }
  ASSERT_TRUE(document->finish(model, 0).ok());
  int64_t ticks = 0, forces = 0;
  for (const StepId step : {2, 3}) {
    ASSERT_TRUE(document
                    ->for_ticks(step,
                                [&](const std::vector<RecordedTick>& block) -> Status {
                                  ticks += static_cast<int64_t>(block.size());
                                  return Ok{};
                                })
                    .ok());
    ASSERT_TRUE(document
                    ->for_forces(step,
                                 [&](const std::vector<Wrench>& block) -> Status {
                                   forces += static_cast<int64_t>(block.size());
                                   return Ok{};
                                 })
                    .ok());
  }
  EXPECT_EQ(ticks, 1000120);
  EXPECT_EQ(forces, 0);
  // The leading part that all blocks share is kept.
  size_t kept = 0;
  ASSERT_TRUE(document
                  ->for_given(3,
                              [&](const std::vector<Wrench>& block) -> Status {
                                for (const Wrench& row : block)
                                  kept += row.force == given.force && row.moment == given.moment;
                                return Ok{};
                              })
                  .ok());
  EXPECT_EQ(kept, 20u);
  EXPECT_EQ(wrongs(*document), std::vector<std::string>());
}

// A stock may have no material. A deposit in it is stored.
TEST(Document, AnEmptyStockIsAStock) {
  Folder folder;
  TriDexel model(make_lattice(Vec3(20, 20, 20), 1, 0).value());
  const uint64_t empty = model.content_hash();
  auto document = created(folder / "a.kibori", model);
  ASSERT_NE(document, nullptr);
  StrokeSettings s;
  s.mode = Mode::deposit;
  s.tool = BallTool{4};
  const Pose start{Vec3(6, 10, 6), Mat3::Identity()};
  ASSERT_TRUE(document->begin(s, start).ok());
  MoveTick tick;
  tick.tip = Vec3(12, 10, 6);
  tick.edits = true;
  ASSERT_TRUE(DirectTool(model, start)
                  .advance(s.tool, tick.tip, tick.turn, s.mode, s.force.law, s.materials)
                  .ok());
  document->add({tick});
  ASSERT_TRUE(document->finish(model, 0).ok());
  document.reset();
  auto after = opened(folder / "a.kibori");
  ASSERT_NE(after, nullptr);
  EXPECT_EQ(wrongs(*after), std::vector<std::string>());
  auto loaded = after->load();
  ASSERT_TRUE(loaded.ok()) << loaded.error();
  EXPECT_EQ(loaded.value()->content_hash(), model.content_hash());
  ASSERT_TRUE(after->undo(*loaded.value()).ok());
  EXPECT_EQ(loaded.value()->content_hash(), empty);
}

}  // namespace
}  // namespace kibori::document_tests
