// SPDX-License-Identifier: MIT
// Documents: what is kept is what was done; against a naive model that keeps full copies, killed processes,
// damaged files and a second writer.
#include <array>
#include <bit>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include <signal.h>
#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <kibori/base/file.h>
#include <kibori/document/document.h>

#include "tests/fault_vfs.h"
#include "tests/support.h"

namespace kibori {
namespace {

using test::Random;

// How often, unless the environment says: a campaign asks for more, a sanitiser for less.
int rounds_of(const char* name, int otherwise) {
  if (const char* said = std::getenv(name)) return std::atoi(said);
  return std::getenv("KIBORI_SHORT") ? otherwise / 5 : otherwise;
}

struct Folder {
  Folder() {
    char name[] = "/tmp/kibori-document-XXXXXX";
    path = mkdtemp(name);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path operator/(const char* name) const { return path / name; }
  std::filesystem::path path;
};

TriDexel block(double pitch = 1) {
  TriDexel model(make_lattice(Vec3(40, 30, 20), pitch, 4).value());
  model.fill_block({Vec3::Zero(), Vec3(40, 30, 20)}, 0);
  return model;
}

std::unique_ptr<Document> created(const std::filesystem::path& path, const TriDexel& model) {
  auto made = Document::create(path, model, "{}");
  EXPECT_TRUE(made.ok()) << made.error();
  return std::move(made).value();
}
std::unique_ptr<Document> opened(const std::filesystem::path& path,
                                 Document::Access access = Document::Access::write) {
  auto open = Document::open(path, access);
  EXPECT_TRUE(open.ok()) << open.error();
  return open.ok() ? std::move(open).value() : nullptr;
}

StrokeSettings some_settings(Random& random) {
  StrokeSettings s;
  const Tool tools[] = {BallTool{random.uniform(1, 5)},
                        Finger{0.2, 20},
                        Flat{2, 15},
                        Cone{60, 3, 15},
                        Bull{3, 1, 12},
                        Capsule{2, 9},
                        BoxTool{Vec3(3, 4, 5)},
                        Ellipsoid{Vec3(3, 2, 4)}};
  s.tool = tools[random.integer(0, 7)];
  s.mode = random.integer(0, 3) == 0 ? Mode::deposit : Mode::cut;
  s.materials.resize(2);
  s.material = static_cast<uint8_t>(random.integer(0, 1));
  s.force.law.model = random.integer(0, 1) ? ForceModel::paper : ForceModel::energy;
  return s;
}

// A stroke of some ticks through the block, told to the document as it is carved.
void carve(Document& document, TriDexel& model, Random& random, int ticks, bool finish = true) {
  const StrokeSettings s = some_settings(random);
  const Pose start{random.in_box(0, 30), frame_from_axis(random.direction(), 0)};
  ASSERT_TRUE(document.begin(s, start, "by chance").ok());
  Stroke stroke(model, start);
  const Vec3 way = random.direction();
  double removed = 0;
  for (int i = 0; i < ticks; i++) {
    StrokeTick tick;
    tick.tip = stroke.pose().tip + way * random.uniform(0, 0.6);
    if (i % 5 == 0) tick.turn = 0.02 * random.direction();
    tick.edits = random.integer(0, 9) != 0;
    const auto done = stroke.advance(s.tool, tick.tip, tick.turn, tick.edits ? s.mode : Mode::off,
                                     s.force.law, s.materials, s.material);
    ASSERT_TRUE(done.ok()) << done.error();
    removed += done.value().removed_mm3;
    document.add(tick);
    if (i % 7 == 6) {
      ASSERT_TRUE(document.flush().ok());
    }
  }
  if (finish) {
    ASSERT_TRUE(document.finish(model, removed).ok());
  }
}

// A long way through the air, after which tiles are kept.
void wander(Document& document, const TriDexel& model) {
  ASSERT_TRUE(document.begin({}, {}).ok());
  for (int t = 0; t < 41000; t++) document.add({});
  ASSERT_TRUE(document.finish(model, 0).ok());
  ASSERT_TRUE(document.flush().ok());
}

std::vector<std::string> wrongs(const Document& document) {
  std::vector<std::string> list;
  const Status done = document.verify([&](const std::string& wrong) { list.push_back(wrong); });
  if (!done) list.push_back(done.error());
  return list;
}

TEST(Codec, SettingsOfEveryToolComeBack) {
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = {Vec3(0, 0, 0), Vec3(1.0 / 3, 0, 0), Vec3(0, 1e-7, 0), Vec3(0, 0, 5)};
  mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const Tool tools[] = {Finger{0.1, 1.0 / 3},     BallTool{2.2}, Flat{1, 2},  Bull{3, 1.1, 12},
                        Cone{61, 3, 15},          Capsule{2, 9}, HalfSpace{}, BoxTool{Vec3(3, 4, 5)},
                        Ellipsoid{Vec3(3, 2, 4)}, MeshTool{mesh}};
  for (const Tool& tool : tools) {
    StrokeSettings s;
    s.tool = tool;
    s.mode = Mode::touch;
    s.materials = {Material{}, {"oak \"a\"", 0.1, 1.0 / 7, 1e-5, 0.3, {1, 2, 255}}};
    s.material = 1;
    s.rate_hz = 2000;
    s.force.series = tool.index() % 2;
    s.force.spring = {1.5, 20, 0.1, 1.0 / 2000};
    s.force.law = {ForceModel::energy, 6};
    const auto back = settings_from_json(settings_to_json(s));
    ASSERT_TRUE(back.ok()) << back.error();
    const StrokeSettings& b = back.value();
    if (const auto* m = std::get_if<MeshTool>(&tool)) {
      EXPECT_EQ(std::get<MeshTool>(b.tool).mesh->vertices, m->mesh->vertices);
      EXPECT_EQ(std::get<MeshTool>(b.tool).mesh->triangles, m->mesh->triangles);
    } else {
      EXPECT_TRUE(same_tool(b.tool, tool));
    }
    EXPECT_EQ(settings_to_json(b), settings_to_json(s));
    EXPECT_EQ(b.mode, s.mode);
    EXPECT_EQ(b.materials[1].u, 1.0 / 7);
    EXPECT_EQ(b.force.series, s.force.series);
    EXPECT_EQ(b.force.spring.stiffness_n_mm, s.force.series ? 1.5 : SeriesSpring{}.stiffness_n_mm);
  }
  for (const char* bad :
       {"", "[]", "{}", R"({"tool":{"shape":"ball","radius":-1}})", R"({"tool":{"shape":"spoon"}})",
        R"({"tool":{"shape":"ball","radius":1},"mode":"cut","rate_hz":0})",
        R"({"tool":{"shape":"mesh","vertices":[[0,0,0]],"triangles":[[0,1,2]]}})"})
    EXPECT_FALSE(settings_from_json(bad).ok()) << bad;
}

std::array<uint64_t, 3> bits_of(const Vec3& v) {
  return {std::bit_cast<uint64_t>(v.x()), std::bit_cast<uint64_t>(v.y()), std::bit_cast<uint64_t>(v.z())};
}

TEST(Codec, TicksComeBackBitForBit) {
  Random random;
  for (const size_t count : {0u, 1u, 2u, 50u, 3000u}) {
    std::vector<StrokeTick> ticks(count);
    for (StrokeTick& t : ticks) {
      t.tip = random.in_box(-1e3, 1e3);
      t.hand = random.in_box(-1, 1) * std::pow(10, random.uniform(-300, 10));
      if (random.integer(0, 1)) t.turn = Vec3(-0.0, 5e-324, 1);
      t.edits = random.integer(0, 1);
    }
    const auto back = decode_ticks(encode_ticks(ticks.data(), count));
    ASSERT_TRUE(back.ok());
    ASSERT_EQ(back.value().size(), count);
    for (size_t i = 0; i < count; i++) {
      EXPECT_EQ(bits_of(back.value()[i].tip), bits_of(ticks[i].tip));
      EXPECT_EQ(bits_of(back.value()[i].turn), bits_of(ticks[i].turn));
      EXPECT_EQ(bits_of(back.value()[i].hand), bits_of(ticks[i].hand));
      EXPECT_EQ(back.value()[i].edits, ticks[i].edits);
    }
  }
}

// History against full copies.
TEST(Document, UndoRedoAndBranchesAgainstFullCopies) {
  Random random;
  Folder folder;
  const int steps = rounds_of("KIBORI_HISTORY", 600);
  auto model = std::make_unique<TriDexel>(block());
  auto document = created(folder / "a.kibori", *model);
  std::map<StepId, uint64_t> truth{{1, model->content_hash()}};
  std::vector<StepId> undone;  // by us, in order
  std::map<StepId, StepId> parent;
  for (int i = 0; i < steps; i++) {
    const int what = random.integer(0, 9);
    if (what < 4) {
      const StepId before = document->head();
      carve(*document, *model, random, random.integer(1, 20));
      truth[document->head()] = model->content_hash();
      parent[document->head()] = before;
    } else if (what < 6) {
      const StepId at = document->head();
      const Status done = document->undo(*model);
      ASSERT_EQ(done.ok(), at != 1);
      if (done) {
        ASSERT_EQ(document->head(), parent[at]);
      }
    } else if (what < 8) {
      const StepId at = document->head();
      const bool any =
          std::any_of(parent.begin(), parent.end(), [&](const auto& p) { return p.second == at; });
      ASSERT_EQ(document->redo(*model).ok(), any);
      if (any) {
        ASSERT_EQ(parent[document->head()], at);
      }
    } else if (what == 8) {
      const StepId to =
          std::next(truth.begin(), random.integer(0, static_cast<int>(truth.size()) - 1))->first;
      ASSERT_TRUE(document->go(*model, to).ok());
      ASSERT_EQ(document->head(), to);
    } else {
      // Halfway through a stroke, never mind.
      carve(*document, *model, random, 5, false);
      ASSERT_TRUE(document->cancel().ok());
      ASSERT_TRUE(document->go(*model, document->head()).ok());
    }
    ASSERT_EQ(model->content_hash(), truth[document->head()]) << i << random.note();
    if (i % 100 == 99) {
      // Closed and opened again, it is the same; and goes anywhere with nothing in memory.
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

// Every step has its tiles once there was time to keep them, so that no way needs a stroke carved again: here
// none could be, as their ticks are gone.
TEST(Document, GoesAnywhereByTiles) {
  Random random;
  Folder folder;
  std::map<StepId, uint64_t> truth;
  TriDexel model = block();
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
    const Status went = document->go(live, step);
    ASSERT_TRUE(went.ok()) << went.error();
    ASSERT_EQ(live.content_hash(), truth[step]) << step << random.note();
  }
}

// A step that fills beyond all that was there, and a tall tool through it, both without tiles and on another
// branch than the head: what is known of where material can be grows on the way.
TEST(Document, FillsThatAreCarvedAgainBesideTheModel) {
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
      Stroke stroke(model, start);
      for (int i = 0; i < 40; i++) {
        StrokeTick tick;
        tick.tip = stroke.pose().tip + Vec3(0.5, 0, 0);
        tick.edits = true;
        ASSERT_TRUE(stroke.advance(s.tool, tick.tip, tick.turn, s.mode, s.force.law, s.materials).ok());
        document->add(tick);
      }
      ASSERT_TRUE(document->finish(model, 0).ok());
    }
  }
  auto database = Database::open(file, Database::Access::write);
  ASSERT_TRUE(database.ok() && database.value()
                                   .run("DELETE FROM checkpoint_tile WHERE step > 1; DELETE FROM checkpoint "
                                        "WHERE step > 1; UPDATE meta SET value = 1 WHERE key = 'head'")
                                   .ok());
  database = Database();
  for (const bool elsewhere : {true, false}) {
    auto document = opened(file);
    auto model = document->load();
    ASSERT_TRUE(model.ok()) << model.error();
    TriDexel& live = *model.value();
    for (const StepId step : {2, 3, 2, 1, 3}) {
      if (elsewhere) {
        auto to = document->destination(step);
        ASSERT_TRUE(to.ok()) << to.error();
        live.include_material(to.value().material_bounds);
        live.restore(to.value().state);
        ASSERT_TRUE(document->went(to.value()).ok());
      } else {
        ASSERT_TRUE(document->go(live, step).ok());
      }
      EXPECT_EQ(live.content_hash(), document->steps().at(step).hash) << step;
    }
    ASSERT_TRUE(document->go(live, 1).ok());
  }
}

// Rows of tiles that belong to no step, to none that has tiles, or lie nowhere: passed by, or told.
TEST(Document, TilesOfNoStep) {
  Random random;
  for (const char* const harm : {"PRAGMA foreign_keys = OFF; INSERT INTO checkpoint_tile SELECT -1, field, "
                                 "u, v, NULL FROM checkpoint_tile WHERE "
                                 "step = 5",
                                 "PRAGMA foreign_keys = OFF; INSERT INTO checkpoint_tile SELECT 0, field, u, "
                                 "v, NULL FROM checkpoint_tile WHERE step "
                                 "= 5",
                                 "PRAGMA foreign_keys = OFF; DELETE FROM checkpoint WHERE step = 7",
                                 "UPDATE checkpoint SET bounds = 'x' WHERE step = 4"}) {
    Folder folder;
    {
      TriDexel model = block();
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

// For a model that only another thread may touch.
TEST(Document, DestinationsForAModelElsewhere) {
  Random random;
  Folder folder;
  std::map<StepId, uint64_t> truth;
  {
    TriDexel model = block();
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
  EXPECT_FALSE(document->destination(5).ok()) << "there is no model yet";
  auto model = document->load();
  ASSERT_TRUE(model.ok());
  TriDexel& live = *model.value();
  const auto go = [&](StepId step) {
    auto to = document->destination(step);
    ASSERT_TRUE(to.ok()) << to.error();
    // Made beside it, while it goes on.
    EXPECT_TRUE(to.value().state.of_same_model(live.snapshot()));
    live.restore(to.value().state);
    ASSERT_TRUE(document->went(to.value()).ok());
    EXPECT_EQ(live.content_hash(), truth[step]) << step;
  };
  for (const StepId step : {StepId{206}, StepId{205}, StepId{5}, StepId{1}, StepId{190}, StepId{204}})
    go(step);
  for (int i = 0; i < 300; i++) go(random.integer(1, 206));
  // A stroke after that, and back; one whose state is of another model is not mixed with these.
  go(190);
  TriDexel other = block();
  carve(*document, live, random, 3);
  const StepId fresh = document->head();
  truth[fresh] = live.content_hash();
  carve(*document, other, random, 3);
  go(fresh);
  go(190);
  EXPECT_FALSE(document->destination(4711).ok());
}

TEST(Document, ForcesAreKeptWhereAskedForAndVerified) {
  Random random;
  Folder folder;
  TriDexel model = block();
  auto document = created(folder / "f.kibori", model);
  StrokeSettings s;
  s.tool = BallTool{3};
  const Pose start{Vec3(5, 10, 18), Mat3::Identity()};
  std::vector<Wrench> felt;
  ASSERT_TRUE(document->begin(s, start).ok());
  Stroke stroke(model, start);
  for (int i = 0; i < 40; i++) {
    StrokeTick tick;
    tick.tip = stroke.pose().tip + Vec3(0.7, 0, -0.05);
    tick.edits = true;
    const auto done = stroke.advance(s.tool, tick.tip, tick.turn, s.mode, s.force.law, s.materials);
    ASSERT_TRUE(done.ok());
    felt.push_back(done.value().wrench);
    document->add(tick, &felt.back());
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
  ASSERT_EQ(kept.size(), felt.size());
  double most = 0;
  for (size_t i = 0; i < kept.size(); i++) {
    EXPECT_EQ(kept[i].force, felt[i].force);
    EXPECT_EQ(kept[i].moment, felt[i].moment);
    most = std::max(most, kept[i].force.squaredNorm());
  }
  EXPECT_GT(most, 0);
  EXPECT_TRUE(read(3).empty());
  EXPECT_EQ(wrongs(*document), std::vector<std::string>());
  document.reset();
  // Others in their place: told.
  felt[20].force.x() += 1e-9;
  {
    auto database = Database::open(folder / "f.kibori", Database::Access::write);
    ASSERT_TRUE(database.ok());
    auto change = database.value().prepare("UPDATE force SET data = ?, count = 40 WHERE sequence = 0");
    ASSERT_TRUE(change.value().bind(encode_forces(felt.data(), felt.size())).run().ok());
    ASSERT_TRUE(database.value().run("DELETE FROM force WHERE sequence > 0").ok());
  }
  document = opened(folder / "f.kibori", Document::Access::read);
  const auto told = wrongs(*document);
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].find("step 2: the forces kept of 1 ticks"), std::string::npos) << told[0];
}

TEST(Document, ThumbnailsAreKeptByStep) {
  Folder folder;
  TriDexel model = block();
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

TEST(Document, KeepsVersionsLabelsAndTheStock) {
  Random random;
  Folder folder;
  TriDexel model = block();
  {
    auto made = Document::create(folder / "a.kibori", model, R"({"kind":"block"})", Bytes{1, 2, 3});
    ASSERT_TRUE(made.ok()) << made.error();
    carve(*made.value(), model, random, 10);
    ASSERT_TRUE(made.value()->name_version("first try", 2).ok());
    EXPECT_FALSE(made.value()->name_version("7", 2).ok());
    EXPECT_FALSE(made.value()->name_version("ghost", 99).ok());
    EXPECT_FALSE(Document::create(folder / "a.kibori", model, "{}").ok());  // it is there
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
  TriDexel model = block();
  auto document = created(folder / "a.kibori", model);
  for (int i = 0; i < 3; i++) carve(*document, model, random, 10);
  carve(*document, model, random, 14, false);  // a stroke that is being made goes as far as it was flushed
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

// A document of each version that there was opens and is what it was.
TEST(Document, OldVersionsOpen) {
  for (const auto& [name, hash, steps] : {std::tuple{"v1.kibori", uint64_t{0xdc65b2b1f2342f8d}, 5u},
                                          std::tuple{"v2.kibori", uint64_t{0xcd2533db3542f74d}, 5u},
                                          std::tuple{"v3.kibori", uint64_t{0xcd2533db3542f74d}, 5u},
                                          std::tuple{"v4.kibori", uint64_t{0xb3b36bf741014dd7}, 6u}}) {
    Folder folder;
    std::filesystem::copy(std::filesystem::path(KIBORI_SOURCE_DIR) / "tests/documents" / name, folder / name);
    auto document = opened(folder / name, Document::Access::read);
    ASSERT_NE(document, nullptr);
    EXPECT_EQ(wrongs(*document), std::vector<std::string>());
    EXPECT_TRUE(document->thumbnail(1).ok());
    // Opened for writing, it has all that is new.
    document.reset();
    document = opened(folder / name);
    ASSERT_NE(document, nullptr);
    EXPECT_TRUE(document->set_thumbnail(3, {1, 2, 3}).ok());
    EXPECT_EQ(document->steps().size(), steps);
    EXPECT_EQ(wrongs(*document), std::vector<std::string>());
    const auto model = document->load();
    ASSERT_TRUE(model.ok()) << model.error();
    EXPECT_EQ(model.value()->content_hash(), hash);
    EXPECT_EQ(document->find("before the turn").value(), 3);
    for (const StepId step : {2, 5, 1, 3, 4}) {
      EXPECT_TRUE(document->go(*model.value(), step).ok());
      EXPECT_EQ(model.value()->content_hash(), document->steps().at(step).hash) << name << " " << step;
    }
  }
}

TEST(Document, OneWriterManyReaders) {
  Random random;
  Folder folder;
  TriDexel model = block();
  auto writer = created(folder / "a.kibori", model);
  const auto second = Document::open(folder / "a.kibori", Document::Access::write);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().find("another process"), std::string::npos);
  // A stroke that is being made is seen as far as it was flushed.
  carve(*writer, model, random, 20, false);
  auto reader = opened(folder / "a.kibori", Document::Access::read);
  ASSERT_NE(reader, nullptr);
  EXPECT_EQ(reader->head(), 2);
  EXPECT_EQ(reader->steps().at(2).ticks, 14);
  EXPECT_TRUE(reader->load().ok());
  ASSERT_TRUE(writer->finish(model, 0).ok());
  auto later = opened(folder / "a.kibori", Document::Access::read);
  EXPECT_EQ(later->load().value()->content_hash(), model.content_hash());
}

// A second writer is refused and leaves the first as it was, whatever a reader does then.
TEST(Document, ARefusedWriterHarmsNobody) {
  Random random;
  Folder folder;
  TriDexel model = block();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto writer = created(folder / "a.kibori", model);
    carve(*writer, model, random, 5);
    if (Document::open(folder / "a.kibori", Document::Access::write).ok()) _exit(1);
    // A reader elsewhere comes and goes, the last but for the writer.
    const pid_t reader = fork();
    if (reader == 0) {
      static_cast<void>(Document::open(folder / "a.kibori", Document::Access::read).ok());
      _exit(0);
    }
    int status = 0;
    waitpid(reader, &status, 0);
    for (int i = 0; i < 5; i++) carve(*writer, model, random, 5);
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  auto after = opened(folder / "a.kibori");
  ASSERT_NE(after, nullptr);
  EXPECT_EQ(after->steps().size(), 7u);
  EXPECT_EQ(wrongs(*after), std::vector<std::string>());
}

// What a killed process left beside a document that is gone is not taken for a new one's.
TEST(Document, LeftoversOfAnotherAreNotTakenIn) {
  Random random;
  Folder folder;
  TriDexel model = block(2);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto writer = created(folder / "a.kibori", model);
    carve(*writer, model, random, 5);
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(std::filesystem::exists(folder / "a.kibori-wal"));
  std::filesystem::rename(folder / "a.kibori", folder / "elsewhere.kibori");
  const auto refused = Document::create(folder / "a.kibori", model, "{}");
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().find("a.kibori-wal"), std::string::npos) << refused.error();
  auto other = created(folder / "b.kibori", model);
  EXPECT_FALSE(other->save_copy(folder / "a.kibori").ok());
  // Put back, it is whole.
  std::filesystem::rename(folder / "elsewhere.kibori", folder / "a.kibori");
  EXPECT_EQ(opened(folder / "a.kibori")->steps().size(), 2u);
}

TEST(Document, ReadersChangeNothingAndSeeOneMoment) {
  Random random;
  Folder folder;
  TriDexel model = block();
  auto writer = created(folder / "a.kibori", model);
  carve(*writer, model, random, 5);
  ASSERT_TRUE(writer->begin({}, {}).ok());
  for (int i = 0; i < 100; i++) writer->add({});
  ASSERT_TRUE(writer->flush().ok());
  auto reader = opened(folder / "a.kibori", Document::Access::read);
  ASSERT_NE(reader, nullptr);
  EXPECT_FALSE(reader->name_version("x", 2).ok());
  EXPECT_EQ(reader->unsaved(), "");
  EXPECT_FALSE(reader->begin({}, {}).ok());
  writer->add({});
  ASSERT_TRUE(writer->flush().ok());
  EXPECT_EQ(wrongs(*reader), std::vector<std::string>());
  ASSERT_TRUE(writer->cancel().ok());
  EXPECT_EQ(wrongs(*reader), std::vector<std::string>());
  ASSERT_TRUE(reader->save_copy(folder / "copy.kibori").ok());
  EXPECT_EQ(wrongs(*opened(folder / "copy.kibori")), std::vector<std::string>());
}

TEST(Document, OnlyFinishedStepsHaveNamesAndPictures) {
  Random random;
  Folder folder;
  TriDexel model = block();
  auto document = created(folder / "a.kibori", model);
  carve(*document, model, random, 5, false);
  EXPECT_FALSE(document->name_version("x", 2).ok());
  EXPECT_FALSE(document->set_thumbnail(2, {1}).ok());
  EXPECT_TRUE(document->cancel().ok());
  EXPECT_EQ(document->unsaved(), "");
}

TEST(Document, RedoGoesBackTheWayThatWasUndone) {
  Random random;
  Folder folder;
  TriDexel model = block();
  auto document = created(folder / "a.kibori", model);
  for (int i = 0; i < 3; i++) carve(*document, model, random, 5);  // 1 2 3 4
  ASSERT_TRUE(document->go(model, 2).ok());
  carve(*document, model, random, 5);  // 5, after 2
  ASSERT_TRUE(document->go(model, 4).ok());
  ASSERT_TRUE(document->go(model, 1).ok());
  for (const StepId next : {2, 3, 4}) {
    ASSERT_TRUE(document->redo(model).ok());
    EXPECT_EQ(document->head(), next);
  }
  EXPECT_FALSE(document->redo(model).ok());
}

// A destination that is not gone to changes nothing.
TEST(Document, DroppedDestinations) {
  Random random;
  Folder folder;
  TriDexel model = block();
  uint64_t second = 0;
  {
    auto document = created(folder / "a.kibori", model);
    carve(*document, model, random, 5);
    second = model.content_hash();
    for (int i = 0; i < 4; i++) carve(*document, model, random, 5);
    wander(*document, model);
    for (int i = 0; i < 70; i++) carve(*document, model, random, 2);
  }
  auto document = opened(folder / "a.kibori");
  auto loaded = document->load();
  ASSERT_TRUE(loaded.ok());
  ASSERT_TRUE(document->destination(3).ok());
  EXPECT_TRUE(document->undo(*loaded.value()).ok());
  EXPECT_TRUE(document->go(*loaded.value(), 2).ok());
  EXPECT_EQ(loaded.value()->content_hash(), second);
}

TEST(Document, AMillionTicksAtOnceAndForcesOfSome) {
  Folder folder;
  TriDexel model = block();
  auto document = created(folder / "a.kibori", model);
  const Wrench felt;
  ASSERT_TRUE(document->begin({}, {}).ok());
  for (int i = 0; i < 1000100; i++) document->add({});
  ASSERT_TRUE(document->finish(model, 0).ok());
  ASSERT_TRUE(document->begin({}, {}).ok());
  for (int i = 0; i < 20; i++) {
    document->add({}, i == 15 ? nullptr : &felt);
    if (i % 4 == 3) {
      ASSERT_TRUE(document->flush().ok());
    }
  }
  ASSERT_TRUE(document->finish(model, 0).ok());
  int64_t ticks = 0, forces = 0;
  for (const StepId step : {2, 3}) {
    ASSERT_TRUE(document
                    ->for_ticks(step,
                                [&](const std::vector<StrokeTick>& block) -> Status {
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
  EXPECT_EQ(wrongs(*document), std::vector<std::string>());
}

TEST(Document, RefusesWhatIsNone) {
  Folder folder;
  EXPECT_FALSE(Document::open(folder / "missing.kibori", Document::Access::read).ok());
  EXPECT_FALSE(Document::open(folder.path, Document::Access::read).ok());
  std::ofstream(folder / "text.kibori")
      << "no document at all, but long enough to be taken for one by its length";
  EXPECT_FALSE(Document::open(folder / "text.kibori", Document::Access::read).ok());
  std::ofstream(folder / "empty.kibori").close();
  EXPECT_FALSE(Document::open(folder / "empty.kibori", Document::Access::write).ok());
  EXPECT_FALSE(Document::create(folder / "no/such/folder.kibori", block(), "{}").ok());
  // Of a newer version.
  { created(folder / "new.kibori", block()); }
  auto database = Database::open(folder / "new.kibori", Database::Access::write);
  ASSERT_TRUE(database.ok() && database.value().run("PRAGMA user_version=1000").ok());
  const auto newer = Document::open(folder / "new.kibori", Document::Access::read);
  ASSERT_FALSE(newer.ok());
  EXPECT_NE(newer.error().find("newer"), std::string::npos);
}

// Bits flipped and files cut anywhere: refused with a sentence, or read; what verify passes is what it was.
// A tile whose material is none, and one that no list of a stroke's has: refused, or as the last of the list.
TEST(Document, MaterialsThatAreNone) {
  for (const uint8_t material : {uint8_t{64}, uint8_t{200}, uint8_t{63}}) {
    Random random;
    Folder folder;
    TriDexel model = block(2);
    Plane& first = model.field(Axis::z).writable(0, 0).first;
    for (int i = 0; i < kTileRays; i++) first.material[i] = material;
    model.field(Axis::z).writable(0, 0).material = material;
    if (material > 63) {
      Field other(Axis::z, model.lattice().nodes);
      EXPECT_FALSE(decode_tile(encode_tile(model.field(Axis::z).tile(0, 0)), other, 0, 0).ok());
      continue;
    }
    auto document = created(folder / "a.kibori", model);
    StrokeSettings s;
    s.tool = BallTool{6};
    const Pose start{Vec3(-4, 10, 15), Mat3::Identity()};
    ASSERT_TRUE(document->begin(s, start).ok());
    Stroke stroke(model, start);
    StrokeTick tick;
    tick.tip = Vec3(30, 10, 15);
    tick.edits = true;
    const auto felt = stroke.advance(s.tool, tick.tip, tick.turn, s.mode, s.force.law, s.materials);
    ASSERT_TRUE(felt.ok());
    EXPECT_GT(felt.value().wrench.force.squaredNorm(), 0);
    document->add(tick);
    ASSERT_TRUE(document->finish(model, 0).ok());
    EXPECT_EQ(wrongs(*document), std::vector<std::string>());
  }
}

TEST(Document, DamageIsToldAndNeverCrashes) {
  Random random;
  Folder folder;
  uint64_t hash = 0;
  {
    TriDexel model = block();
    auto document = created(folder / "a.kibori", model);
    for (int i = 0; i < 4; i++) carve(*document, model, random, 10);
    hash = model.content_hash();
  }
  const std::vector<char> whole = read_file(folder / "a.kibori").value();
  const int rounds = rounds_of("KIBORI_FLIPS", 300);
  int refused = 0, told = 0, unharmed = 0;
  for (int i = 0; i < rounds; i++) {
    std::vector<char> bytes = whole;
    const auto place = [&] {
      return static_cast<size_t>(random.uniform(0, 1) * static_cast<double>(bytes.size() - 1));
    };
    if (i % 20 == 0)
      bytes.resize(place());
    else
      for (int k = random.integer(1, 3); k > 0; k--)
        bytes[place()] ^= static_cast<char>(1 << random.integer(0, 7));
    std::ofstream(folder / "b.kibori", std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    auto document = Document::open(folder / "b.kibori", Document::Access::read);
    if (!document) {
      EXPECT_FALSE(document.error().empty());
      refused++;
      continue;
    }
    const auto model = document.value()->load();
    if (!wrongs(*document.value()).empty()) {
      told++;
    } else if (document.value()->head() == 5 && document.value()->steps().size() == 5) {
      ASSERT_TRUE(model.ok()) << model.error();
      ASSERT_EQ(model.value()->content_hash(), hash) << i << random.note();
      unharmed++;
    }
  }
  std::printf("%d refused, %d told by verify, %d unharmed\n", refused, told, unharmed);
  EXPECT_GT(refused + told, rounds / 10);
}

// Killed at any moment: an exact prefix of what was done, and little of it missing.
TEST(Document, KilledProcessesLeaveAPrefix) {
  Random random;
  Folder folder;
  const int kills = rounds_of("KIBORI_KILLS", 12);
  for (int round = 0; round < kills; round++) {
    const auto file = folder / "k.kibori", log = folder / "told";
    std::filesystem::remove(file);
    std::filesystem::remove(folder / "k.kibori-wal");
    std::filesystem::remove(folder / "k.kibori-shm");
    std::filesystem::remove(log);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      // Writes how many ticks were flushed after each flush, as a pipe would lose it.
      TriDexel model = block();
      auto made = Document::create(file, model, "{}");
      if (!made) _exit(1);
      std::ofstream told(log, std::ios::binary);
      int64_t ticks = 0;
      for (int s = 0; s < 1000; s++) {
        StrokeSettings settings;
        settings.tool = BallTool{2};
        const Pose start{Vec3(5, 5 + s % 20, 19), Mat3::Identity()};
        if (!made.value()->begin(settings, start)) _exit(1);
        Stroke stroke(model, start);
        for (int i = 0; i < 60; i++) {
          StrokeTick tick;
          tick.tip = stroke.pose().tip + Vec3(0.4, 0, -0.01);
          tick.edits = true;
          if (!stroke.advance(settings.tool, tick.tip, tick.turn, settings.mode, {}, settings.materials))
            _exit(1);
          made.value()->add(tick);
          ticks++;
          if (i % 10 == 9) {
            if (!made.value()->flush()) _exit(1);
            told.write(reinterpret_cast<const char*>(&ticks), 8);
            told.flush();
          }
        }
        if (!made.value()->finish(model, 1)) _exit(1);
      }
      _exit(0);
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random.integer(3000, 150000)));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    if (!std::filesystem::exists(file)) continue;  // killed before it was there
    int64_t told = 0;
    std::ifstream in(log, std::ios::binary);
    for (int64_t next = 0; in.read(reinterpret_cast<char*>(&next), 8);) told = next;
    auto document = opened(file);
    ASSERT_NE(document, nullptr);
    int64_t ticks = 0;
    for (const auto& [id, step] : document->steps()) {
      EXPECT_TRUE(step.finished);
      ticks += step.ticks;
    }
    EXPECT_GE(ticks, told) << random.note();
    EXPECT_LE(ticks, told + 10);
    EXPECT_EQ(wrongs(*document), std::vector<std::string>()) << random.note();
    auto model = document->load();
    ASSERT_TRUE(model.ok()) << model.error();
    EXPECT_EQ(model.value()->content_hash(), document->steps().rbegin()->second.hash);
    // And work goes on.
    carve(*document, *model.value(), random, 5);
  }
}

using test::FaultVfs;

// Every write, sync, truncation and removal fails in turn, once or from then on: it is told, what was there
// stays, what follows is in memory, and all of it can be saved where it belongs once the disk is well again,
// or elsewhere.
TEST(Document, FailingDisksLoseNothing) {
  FaultVfs& vfs = FaultVfs::get();
  Folder folder;
  int told = 0, rescued = 0;
  bool reached = true;
  for (int64_t at = 1; reached; at += std::getenv("KIBORI_SHORT") ? 9 : at < 60 ? 1 : 7) {
    for (const int how : {0, 1, 2}) {
      vfs.reset();
      for (const char* name : {"f.kibori", "g.kibori"})
        for (const char* rest : {"", "-wal", "-shm"}) std::filesystem::remove(folder / name += rest);
      TriDexel model = block();
      { created(folder / "f.kibori", model); }
      auto open = Document::open(folder / "f.kibori", Document::Access::write, FaultVfs::kName);
      ASSERT_TRUE(open.ok()) << open.error();
      Document& document = *open.value();
      vfs.count = 0;
      vfs.fail_at = at;
      vfs.fail_on = how == 1;
      vfs.error = how == 1 ? SQLITE_FULL : SQLITE_IOERR_WRITE;
      vfs.half_written = how == 2;
      std::map<int64_t, uint64_t> truth{{1, model.content_hash()}};
      for (int s = 0; s < 3; s++) {
        StrokeSettings settings;
        settings.tool = BallTool{3};
        const Pose start{Vec3(5, 5 + 5 * s, 18), Mat3::Identity()};
        ASSERT_TRUE(document.begin(settings, start).ok());
        Stroke stroke(model, start);
        for (int i = 0; i < 12; i++) {
          StrokeTick tick;
          tick.tip = stroke.pose().tip + Vec3(0.7, 0, -0.1);
          tick.edits = true;
          const auto felt =
              stroke.advance(settings.tool, tick.tip, tick.turn, settings.mode, {}, settings.materials);
          ASSERT_TRUE(felt.ok());
          document.add(tick, &felt.value().wrench);
          if (i % 4 == 3) {
            ASSERT_TRUE(document.flush().ok());
          }
        }
        ASSERT_TRUE(document.finish(model, 1).ok());
        truth[document.head()] = model.content_hash();
        if (s == 1 && at % 5 == 0) {
          wander(document, model);
          truth[document.head()] = model.content_hash();
        }
      }
      const StepId last = document.head();
      ASSERT_TRUE(document.undo(model).ok());
      EXPECT_EQ(model.content_hash(), truth[last - 1]);
      ASSERT_TRUE(document.redo(model).ok());
      EXPECT_EQ(model.content_hash(), truth[last]);
      // In memory or not, history works.
      EXPECT_EQ(wrongs(document), std::vector<std::string>()) << at << " " << how;
      reached = vfs.count >= at;
      const auto whole = [&](const std::filesystem::path& path) {
        auto after = opened(path);
        ASSERT_NE(after, nullptr);
        ASSERT_EQ(after->steps().size(), truth.size()) << at << " " << how;
        for (const auto& [step, hash] : truth) EXPECT_EQ(after->steps().at(step).hash, hash);
        EXPECT_EQ(wrongs(*after), std::vector<std::string>()) << at << " " << how;
      };
      if (!document.unsaved().empty()) {
        told++;
        EXPECT_NE(document.unsaved().find("f.kibori"), std::string::npos) << document.unsaved();
        // What could be written is there for others, an exact prefix.
        {
          auto reader = Document::open(folder / "f.kibori", Document::Access::read);
          ASSERT_TRUE(reader.ok()) << at << " " << reader.error();
          EXPECT_EQ(wrongs(*reader.value()), std::vector<std::string>()) << at << " " << how;
        }
        if (how == 1) {
          // Still full.
          const Status again = document.save_again();
          EXPECT_FALSE(again.ok());
          EXPECT_FALSE(document.unsaved().empty());
        }
        if (at % 2 == 0) {
          ASSERT_TRUE(document.move_to(folder / "g.kibori").ok());
          EXPECT_EQ(document.unsaved(), "");
          EXPECT_NE(document.name().find("g.kibori"), std::string::npos);
          EXPECT_FALSE(Document::open(folder / "g.kibori", Document::Access::write).ok());
          // The old place is free, and work goes on in the new one.
          { ASSERT_NE(opened(folder / "f.kibori"), nullptr); }
          ASSERT_TRUE(document.undo(model).ok());
          ASSERT_TRUE(document.redo(model).ok());
          open.value().reset();
          whole(folder / "g.kibori");
          rescued++;
          continue;
        }
        vfs.fail_at = 0;
        const Status again = document.save_again();
        ASSERT_TRUE(again.ok()) << at << " " << how << " " << again.error();
        EXPECT_EQ(document.unsaved(), "");
      }
      open.value().reset();
      vfs.fail_at = 0;
      whole(folder / "f.kibori");
    }
  }
  std::printf("%d failures told, %d rescued elsewhere\n", told, rescued);
  EXPECT_GT(rescued, 10);
  EXPECT_GT(told, rescued);
  vfs.reset();
}

// Power is lost after any operation: what was synced is there, of what came later any part, torn anywhere.
// The file then holds an exact prefix, and all that was synced of it.
TEST(Document, LossOfPowerLeavesAPrefix) {
  FaultVfs& vfs = FaultVfs::get();
  vfs.reset();
  Random random;
  Folder folder;
  TriDexel model = block();
  { created(folder / "p.kibori", model); }
  const std::vector<char> before = read_file(folder / "p.kibori").value();
  vfs.log = true;
  std::vector<std::pair<size_t, size_t>> steps_by_op;  // operations so far, steps finished so far
  {
    auto open = Document::open(folder / "p.kibori", Document::Access::write, FaultVfs::kName);
    ASSERT_TRUE(open.ok()) << open.error();
    for (int s = 0; s < 25; s++) {
      carve(*open.value(), model, random, 12);
      steps_by_op.emplace_back(vfs.ops.size(), open.value()->steps().size());
      if (s == 12) wander(*open.value(), model);
      if (s % 8 == 7) std::this_thread::sleep_for(std::chrono::milliseconds(510));
    }
    open.value().reset();
    steps_by_op.emplace_back(vfs.ops.size(), 27);
  }
  vfs.log = false;
  const int rounds = rounds_of("KIBORI_POWER", 150);
  size_t most_lost = 0;
  for (int round = 0; round < rounds; round++) {
    const auto crash = static_cast<size_t>(random.integer(0, static_cast<int>(vfs.ops.size())));
    std::map<std::string, std::vector<char>> files{{"p.kibori", before}};
    std::map<std::string, size_t> synced;  // operations up to here are on the disk
    for (size_t i = 0; i < crash; i++)
      if (vfs.ops[i].kind == FaultVfs::Op::sync) synced[vfs.ops[i].file] = i;
    for (size_t i = 0; i < crash; i++) {
      const FaultVfs::Op& op = vfs.ops[i];
      if (op.kind == FaultVfs::Op::sync) continue;
      const bool sure = synced.count(op.file) && i < synced[op.file];
      if (!sure && random.integer(0, 2) == 0) continue;  // never arrived
      if (op.kind == FaultVfs::Op::remove) {
        files.erase(op.file);
        continue;
      }
      std::vector<char>& file = files[op.file];
      if (op.kind == FaultVfs::Op::truncate) {
        file.resize(static_cast<size_t>(op.at));
        continue;
      }
      size_t length = op.data.size();
      if (!sure && random.integer(0, 3) == 0)
        length = static_cast<size_t>(random.integer(0, static_cast<int>(length)));
      if (file.size() < static_cast<size_t>(op.at) + length) file.resize(static_cast<size_t>(op.at) + length);
      std::copy_n(op.data.begin(), length, file.begin() + op.at);
    }
    for (const char* rest : {"q.kibori", "q.kibori-wal", "q.kibori-shm"})
      std::filesystem::remove(folder / rest);
    for (const auto& [name, bytes] : files) {
      std::string as = name;
      as[0] = 'q';
      if (as.find("-shm") != std::string::npos) continue;
      std::ofstream(folder / as.c_str(), std::ios::binary)
          .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
    auto after = opened(folder / "q.kibori");
    ASSERT_NE(after, nullptr) << round << random.note();
    EXPECT_EQ(wrongs(*after), std::vector<std::string>()) << random.note();
    // All that was finished before the last sync of the log.
    size_t sure = 1, made = 1;
    for (const auto& [ops, steps] : steps_by_op) {
      if (synced.count("p.kibori-wal") && ops <= synced["p.kibori-wal"]) sure = steps;
      if (ops <= crash) made = steps;
    }
    EXPECT_GE(after->steps().size(), sure) << random.note();
    most_lost = std::max(most_lost, made - std::min(made, after->steps().size()));
  }
  std::printf("%zu operations; at most %zu strokes lost\n", vfs.ops.size(), most_lost);
  vfs.reset();
}

}  // namespace
}  // namespace kibori
