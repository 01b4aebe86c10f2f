// SPDX-License-Identifier: MIT
// Shared by the tests of documents: a block, and strokes through it.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/document/codec.h>
#include <kibori/document/database.h>
#include <kibori/document/document.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/motion/direct_tool.h>

#include "tests/every_tool.h"
#include "tests/modes.h"
#include "tests/support.h"

namespace kibori::test {

inline TriDexel stock(double pitch = 1) {
  TriDexel model(make_lattice(Vec3(40, 30, 20), pitch, 4).value());
  model.fill_block({Vec3::Zero(), Vec3(40, 30, 20)}, 0);
  return model;
}

inline std::unique_ptr<Document> created(const std::filesystem::path& path, const TriDexel& model) {
  auto made = Document::create(path, model, "{}");
  EXPECT_TRUE(made.ok()) << made.error();
  return std::move(made).value();
}
inline std::unique_ptr<Document> opened(const std::filesystem::path& path,
                                        Document::Access access = Document::Access::write) {
  auto open = Document::open(path, access);
  EXPECT_TRUE(open.ok()) << open.error();
  return open.ok() ? std::move(open).value() : nullptr;
}

// Position of the tool after the tick [mm].
inline const Vec3& tip_of(const RecordedTick& tick) {
  if (const auto* const move = std::get_if<MoveTick>(&tick.what)) return move->tip;
  if (const auto* const put = std::get_if<PutTick>(&tick.what)) return put->pose.tip;
  return std::get<EndTick>(tick.what).tip;
}

inline StrokeSettings some_settings(Random& random) {
  StrokeSettings s;
  s.tool = random_tool(random, {1, 5, 9, 20});
  s.mode = random.integer(0, 3) == 0 ? Mode::deposit : Mode::cut;
  if (random.integer(0, 3) == 0) {
    s.mode = random_reshaping_mode(random);
    s.brush = {random.uniform(1, 6),
               random.uniform(0, 1),
               static_cast<Falloff>(random.integer(0, 2)),
               random.uniform(0, 2),
               random.integer(0, 1) == 1,
               static_cast<FlattenTo>(random.integer(0, 2))};
  }
  if (random.integer(0, 3) == 0) {
    s.symmetry.planes[static_cast<size_t>(random.integer(0, 2))] = true;
    s.symmetry.fold = random.integer(1, 4);
    s.symmetry.axis = static_cast<Axis>(random.integer(0, 2));
    s.symmetry.centre_mm = Vec3(20, 15, 10);
  }
  s.materials.resize(2);
  s.material = static_cast<uint8_t>(random.integer(0, 1));
  s.force.law.model = random.integer(0, 1) ? ForceModel::paper : ForceModel::energy;
  return s;
}

// Carves a stroke of some ticks through the active body, and reports it to the document.
inline void carve(Document& document, TriDexel& model, Random& random, int ticks,
                  bool finish = true, Crumbs crumbs = Crumbs::stay) {
  StrokeSettings s = some_settings(random);
  s.body = document.active();
  // If only this test carves the document, nothing needs to be loaded.
  const BodyList bodies = document.worked_on() ? *document.worked_on() : BodyList::of(model);
  const bool others_protected =
      std::any_of(bodies.all.begin(), bodies.all.end(),
                  [&](const Body& body) { return body.no_go && body.id != s.body; });
  if (others_protected && reshapes(s.mode)) {
    ASSERT_FALSE(document.begin(s, {}, "by chance").ok());
    s.mode = Mode::cut;
  }
  const auto no_go = no_go_of(bodies, s.body);
  ASSERT_TRUE(no_go.ok()) << no_go.error();
  if (may_sever(s.mode)) s.crumbs = crumbs;
  const Snapshot before = model.snapshot();
  const Pose start{random.in_box(0, 30), frame_from_axis(random.direction(), 0)};
  ASSERT_TRUE(document.begin(s, start, "by chance").ok());
  DirectTool stroke(model, start);
  stroke.set_symmetry(s.symmetry);
  stroke.set_no_go(no_go.value().get());
  ReshapeStroke reshape(model);
  bool begun = false;
  const Vec3 direction = random.direction();
  double removed = 0;
  for (int i = 0; i < ticks; i++) {
    MoveTick tick;
    tick.tip = stroke.pose().tip + direction * random.uniform(0, 0.6);
    if (i % 5 == 0) tick.turn = 0.02 * random.direction();
    tick.edits = random.integer(0, 9) != 0;
    if (reshapes(s.mode) && tick.edits && !std::exchange(begun, true)) {
      const Status fine =
          reshape.begin({s.mode, s.brush, s.tool, s.force.law, s.rate_hz, s.symmetry}, s.materials,
                        stroke.pose());
      ASSERT_TRUE(fine.ok()) << fine.error();
    }
    auto done = stroke.advance(s.tool, tick.tip, tick.turn, tick.edits ? s.mode : Mode::off,
                               s.force.law, s.materials, s.material);
    ASSERT_TRUE(done.ok()) << done.error();
    if (begun) {
      const Status reshaped =
          tick.edits ? reshape.advance(done.value(), i + 1 == ticks) : reshape.end(done.value());
      ASSERT_TRUE(reshaped.ok()) << reshaped.error();
    }
    begun &= tick.edits;
    removed += done.value().removed_mm3;
    document.add({tick});
    if (i % 7 == 6) {
      ASSERT_TRUE(document.flush().ok());
    }
  }
  if (finish) {
    const CrumbResult severed = take_crumbs(model, before, s.crumbs, no_go.value().get());
    ASSERT_TRUE(document.finish(model, removed + severed.fallen_mm3, severed.portions).ok());
  }
}

// Adds a stroke through the air that is so long that the document then stores tiles.
inline void wander(Document& document, const TriDexel& model) {
  ASSERT_TRUE(document.begin({}, {}).ok());
  for (int t = 0; t < 41000; t++) document.add({});
  ASSERT_TRUE(document.finish(model, 0).ok());
  ASSERT_TRUE(document.flush().ok());
}

inline std::vector<std::string> wrongs(const Document& document) {
  std::vector<std::string> list;
  const Status done = document.verify([&](const std::string& wrong) { list.push_back(wrong); });
  if (!done) list.push_back(done.error());
  return list;
}

}  // namespace kibori::test
