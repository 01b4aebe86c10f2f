// SPDX-License-Identifier: MIT
// A workpiece (the model of a Python script), against a replayed document of the same strokes.
#include <gtest/gtest.h>

#include <kibori/run/workpiece.h>
#include <kibori/haptics/materials.h>

#include "tests/document_support.h"

namespace kibori::workpiece_tests {
namespace {

using test::Folder;
using test::Random;

std::unique_ptr<Workpiece> piece(double pitch) {
  Stock stock;
  stock.shape = StockBlock{Vec3(30, 24, 18)};
  stock.pitch_mm = pitch;
  auto made = Workpiece::make(stock, {known_materials().front(), known_materials().back()}, 1);
  EXPECT_TRUE(made.ok()) << made.error();
  return std::move(made).value();
}

Pose somewhere(Random& random) {
  return {random.in_box(-2, 30), frame_from_axis(random.direction(), random.uniform(-3, 3))};
}

// One stroke of any mode; returns the volume that its ticks removed.
double stroke(Workpiece& p, Random& random) {
  StrokeSettings s = test::some_settings(random);
  s.material = static_cast<uint8_t>(random.integer(0, 1));
  s.crumbs = static_cast<Crumbs>(random.integer(0, 3));
  s.force.law.model = static_cast<ForceModel>(random.integer(0, 2));
  const Pose start = somewhere(random);
  if (Status begun = p.begin(s, start, "by chance"); !begun) {
    EXPECT_FALSE(begun.error().empty());
    EXPECT_FALSE(p.in_stroke());
    return 0;
  }
  double removed = 0;
  Pose at = start;
  ToolTick last;
  for (int i = random.integer(1, 6); i > 0; i--) {
    at.tip += 3 * random.direction();
    if (random.integer(0, 1)) at.frame = rotation(0.1 * random.direction()) * at.frame;
    const Result<ToolTick> tick = p.advance(at);
    EXPECT_TRUE(tick.ok()) << tick.error();
    if (!tick) break;
    removed += tick.value().removed_mm3;
    last = tick.value();
  }
  const double before = last.removed_mm3;
  if (random.integer(0, 5) == 0) {
    p.cancel();
    return 0;
  }
  const Result<CrumbResult> ended = p.end(&last);
  EXPECT_TRUE(ended.ok());
  return removed + last.removed_mm3 - before + ended.value().fallen_mm3;
}

TEST(Workpiece, MatchesItsDocument) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int round = 0; round < test::rounds_of("KIBORI_WORKPIECES", 3); round++) {
    Folder folder;
    std::unique_ptr<Workpiece> p = piece(random.uniform(0.7, 2));
    std::map<size_t, uint64_t> hashes{{0, p->bodies().content_hash()}};
    for (int i = 0; i < 15; i++) {
      const uint64_t was = p->bodies().content_hash();
      const size_t done = p->done();
      if (const int what = random.integer(0, 9); what < 6) {
        const size_t bodies = p->bodies().all.size();
        const double volume = p->bodies().volume_mm3();
        const double removed = stroke(*p, random);
        if (bodies == p->bodies().all.size()) {
          EXPECT_NEAR(volume - p->bodies().volume_mm3(), removed,
                      1e-3 * std::abs(removed) + 1e-3 * volume);
        }
        if (p->done() == done) {
          EXPECT_EQ(p->bodies().content_hash(), was);
        }
      } else if (what == 6) {
        const Vec3 point = random.in_box(5, 20), normal = random.direction();
        static_cast<void>(p->act({{}, BodyCut{{CutPlane{point, normal}}}}));
      } else if (what < 9) {
        const Status back = p->undo();
        EXPECT_EQ(back.ok(), done > 0);
      } else {
        static_cast<void>(p->redo());
      }
      const uint64_t now = p->bodies().content_hash();
      if (p->done() > done && p->done() == p->steps()) hashes[p->done()] = now;
      EXPECT_EQ(now, hashes.at(p->done())) << i;
    }
    const uint64_t hash = p->bodies().content_hash();
    // Written twice: directly, and from an opened document.
    for (const char* name : {"a.kibori", "b.kibori"}) {
      ASSERT_TRUE(p->save(folder / name, false).ok());
      EXPECT_FALSE(p->save(folder / name, false).ok());
      const auto document = test::opened(folder / name, Document::Access::read);
      EXPECT_EQ(document->steps().at(document->head()).hash, hash);
      EXPECT_EQ(test::wrongs(*document), std::vector<std::string>());
      auto opened = Workpiece::open(folder / name);
      ASSERT_TRUE(opened.ok()) << opened.error();
      EXPECT_EQ(opened.value()->bodies().content_hash(), hash);
      p = std::move(opened).value();
      stroke(*p, random);
      stroke(*p, random);
      const uint64_t after = p->bodies().content_hash();
      const std::string next = std::string(name) + ".kibori";
      const Status saved = p->save(folder / next.c_str(), true);
      ASSERT_TRUE(saved.ok()) << saved.error();
      const auto more = test::opened(folder / next.c_str(), Document::Access::read);
      EXPECT_EQ(more->steps().at(more->head()).hash, after);
      EXPECT_EQ(test::wrongs(*more), std::vector<std::string>());
      while (p->done() > 0) ASSERT_TRUE(p->undo().ok());
      EXPECT_EQ(p->bodies().content_hash(), hash);
    }
  }
}

TEST(Workpiece, RefusesWhatItCant) {
  std::unique_ptr<Workpiece> p = piece(2);
  EXPECT_FALSE(p->advance({}).ok());
  EXPECT_FALSE(p->end().ok());
  EXPECT_FALSE(p->undo().ok());
  EXPECT_FALSE(p->redo().ok());
  StrokeSettings s;
  s.tool = BallTool{-1};
  EXPECT_FALSE(p->begin(s, {}).ok());
  s.tool = BallTool{1e6};
  EXPECT_FALSE(p->begin(s, {}).ok());
  s.tool = BallTool{3};
  EXPECT_FALSE(p->begin(s, {Vec3(0, 0, std::nan("")), Mat3::Identity()}).ok());
  EXPECT_FALSE(p->begin(s, {Vec3::Zero(), 2 * Mat3::Identity()}).ok());
  s.material = 7;
  EXPECT_FALSE(p->begin(s, {}).ok());
  s.material = 0;
  ASSERT_TRUE(p->begin(s, {}).ok());
  EXPECT_FALSE(p->begin(s, {}).ok());
  EXPECT_FALSE(p->undo().ok());
  EXPECT_FALSE(p->act({}).ok());
  EXPECT_FALSE(p->save("a.kibori", false).ok());
  EXPECT_FALSE(p->advance({Vec3(0, std::nan(""), 0), Mat3::Identity()}).ok());
  p->cancel();
  EXPECT_EQ(p->steps(), 0u);
  EXPECT_FALSE(Workpiece::of(std::make_unique<TriDexel>(p->model().lattice()), {}).ok());
  EXPECT_FALSE(Workpiece::open("nowhere.kibori").ok());
}

}  // namespace
}  // namespace kibori::workpiece_tests
