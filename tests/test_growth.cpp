// SPDX-License-Identifier: MIT
// The lattice grows when a stroke needs room: nodes keep their places, the result is that of a
// lattice that was roomy from the beginning, and documents repeat it.
#include <array>
#include <cmath>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <kibori/body/workbench.h>
#include <kibori/live/document_writer.h>
#include <kibori/measure/distance.h>
#include <kibori/motion/stroke_player.h>
#include <kibori/surface/surface.h>

#include "tests/document_support.h"
#include "tests/live_rig.h"
#include "tests/reshape_support.h"
#include "tests/support.h"
#include "tests/surface_check.h"

namespace kibori::growth_tests {
namespace {

using test::Folder;
using test::Random;

constexpr int kMargin = 64;  // nodes of room around the roomy lattice
constexpr double kBall = 18;
const Vec3 kMiddle(20, 20, 20);

// 44 nodes along each side, 2 mm of room around a box of 40 mm. `margin`: more nodes on each side.
Lattice around_ball(int margin) {
  Lattice lattice = make_lattice(Vec3(40, 40, 40), 1, 2).value();
  lattice.nodes += 2 * margin;
  lattice.origin_mm -= Vec3::Constant(margin * lattice.pitch_mm);
  return lattice;
}

TriDexel ball_in(const Lattice& lattice) {
  TriDexel model(lattice);
  Removed added;
  const Pose pose{kMiddle - Vec3(0, 0, kBall), Mat3::Identity()};
  deposit(model, SweptTool(BallTool{kBall}, pose, Vec3::Zero(), lattice).solid(), 0, {}, added);
  EXPECT_FALSE(added.clipped);
  return model;
}

// ---- The model

// All spans of a snapshot, by field and ray.
std::vector<std::vector<Span>> spans_of(const Snapshot& model, const Lattice& within) {
  std::vector<std::vector<Span>> all;
  for (const Axis axis : kAxes)
    for (int v = within.low()[v_index(axis)]; v < within.high()[v_index(axis)]; v++)
      for (int u = within.low()[u_index(axis)]; u < within.high()[u_index(axis)]; u++) {
        std::vector<Span>& ray = all.emplace_back();
        if (model.field(axis).has_ray(u, v))
          model.field(axis).for_spans(u, v, [&](const Span& span) { ray.push_back(span); });
      }
  return all;
}

bool same_spans(const Snapshot& one, const Snapshot& other) {
  const Lattice within = joined(one.lattice, other.lattice);
  const auto a = spans_of(one, within), b = spans_of(other, within);
  for (size_t ray = 0; ray < a.size(); ray++) {
    if (a[ray].size() != b[ray].size()) return false;
    for (size_t i = 0; i < a[ray].size(); i++)
      if (a[ray][i].in != b[ray][i].in || a[ray][i].out != b[ray][i].out ||
          a[ray][i].normal_in != b[ray][i].normal_in)
        return false;
  }
  return true;
}

// Nodes that are inside only one of the two. `roomy` has kMargin more nodes on each side.
int differing_nodes(const Snapshot& tight, const Snapshot& roomy) {
  const FieldSnapshot &a = tight.field(Axis::z), &b = roomy.field(Axis::z);
  int count = 0;
  const Index3 low = tight.lattice.low(), high = tight.lattice.high();
  for (int k = low[2]; k < high[2]; k++)
    for (int j = low[1]; j < high[1]; j++)
      for (int i = low[0]; i < high[0]; i++) {
        const Index3 node(i, j, k);
        count += a.holds(node) != b.holds(node + kMargin);
      }
  return count;
}

// Share of the rays with material whose ends differ by more than 0.01 cells.
double differing_rays(const Snapshot& tight, const Snapshot& roomy) {
  int all = 0, differ = 0;
  for (const Axis axis : kAxes) {
    const FieldSnapshot &a = tight.field(axis), &b = roomy.field(axis);
    for (int v = a.v_begin(); v < a.v_end(); v++)
      for (int u = a.u_begin(); u < a.u_end(); u++) {
        std::vector<float> ends, others;
        a.for_spans(u, v, [&](const Span& s) { ends.insert(ends.end(), {s.in, s.out}); });
        b.for_spans(u + kMargin, v + kMargin, [&](const Span& s) {
          others.insert(others.end(), {s.in, s.out});
        });
        bool same = ends.size() == others.size();
        for (size_t i = 0; same && i < ends.size(); i++)
          same = std::fabs(ends[i] + kMargin - others[i]) < 0.01f;
        all += !ends.empty() || !others.empty();
        differ += !same;
      }
  }
  return static_cast<double>(differ) / all;
}

TEST(Growth, KeepsNodesHashAndVolume) {
  Random random;
  for (int round = 0; round < 30; round++) {
    Lattice lattice;
    for (int i = 0; i < 3; i++) lattice.nodes[i] = random.integer(1, 90);
    lattice.origin_mm = random.in_box(-30, 30);
    lattice.pitch_mm = random.uniform(0.2, 2);
    TriDexel model(lattice);
    const Box whole = lattice.to_mm(lattice.whole());
    model.fill_block(whole.grown(-0.2 * whole.size().minCoeff()), 1);
    const Snapshot before = model.snapshot();
    const LatticeBox box{lattice.whole().units.grown(random.uniform(-5, 200))};
    const bool grows = box.units.min.x() < 0;
    EXPECT_EQ(model.grow_to(box), grows) << random.note();
    const Lattice& grown = model.lattice();
    EXPECT_TRUE((grown.nodes == lattice.nodes).all());
    for (int i = 0; i < 3; i++) {
      EXPECT_LE(grown.low()[i], std::min(0.0, box.units.min[i]));
      EXPECT_GE(grown.high()[i], std::max<double>(lattice.nodes[i], box.units.max[i]));
      EXPECT_EQ(grown.below[i] % kTileSide, 0);
      EXPECT_TRUE(grown.above[i] == 0 || grown.high()[i] % kTileSide == 0);
    }
    const LatticePoint node{Vec3(3.5, 1.5, 0.5)};
    EXPECT_EQ(grown.to_mm(node), lattice.to_mm(node));
    EXPECT_EQ(model.content_hash(), before.content_hash());
    EXPECT_EQ(model.volume_mm3(), before.volume_mm3());
    EXPECT_TRUE(same_spans(model.snapshot(), before));
    // Tiles are shared, not copied.
    int changed = 0;
    for (const Axis axis : kAxes)
      model.field(axis).view().for_changed_tiles(
          before.field(axis), [&](int, int, const Tile&, const Tile&) { changed++; });
    EXPECT_EQ(changed, 0);
    // The smallest lattice that holds the material is the base lattice.
    EXPECT_FALSE(fitted_lattice(model.snapshot()).grown());
    model.restore(before);
    EXPECT_FALSE(model.lattice().grown());
  }
}

// Random cuts and deposits, in a lattice that grew and in one that was large from the beginning.
TEST(Growth, EditsAreThoseOfARoomyLattice) {
  Random random;
  TriDexel tight = ball_in(around_ball(0)), roomy = ball_in(around_ball(kMargin));
  ASSERT_TRUE(tight.grow_to({around_ball(0).whole().units.grown(kMargin)}));
  for (int i = 0; i < 40; i++) {
    const Pose from{kMiddle + 45 * random.direction(), frame_from_axis(random.direction(), 0)};
    const Tool tool = BallTool{random.uniform(2, 9)};
    const Vec3 travel = 0.6 * (kMiddle - from.tip) + random.in_box(-5, 5);
    const bool adds = random.integer(0, 1) == 1;
    std::array<Removed, 2> sums;
    std::array<TriDexel*, 2> models{&tight, &roomy};
    for (size_t m = 0; m < 2; m++) {
      const SweptTool sweep(tool, from, travel, models[m]->lattice());
      if (adds)
        deposit(*models[m], sweep.solid(), 0, {}, sums[m]);
      else
        cut(*models[m], sweep.solid(), {}, sums[m]);
    }
    EXPECT_NEAR(sums[0].volume(), sums[1].volume(), 1e-3 * (1 + std::fabs(sums[1].volume())))
        << random.note();
  }
  EXPECT_NEAR(tight.volume_mm3(), roomy.volume_mm3(), 1e-4 * roomy.volume_mm3());
  const Surface a = extract_surface(tight.snapshot()), b = extract_surface(roomy.snapshot());
  const auto off = two_sided_distance(a, b, 100000);
  ASSERT_TRUE(off.ok());
  EXPECT_LT(off.value().rms(), 0.02);
  EXPECT_LT(differing_rays(tight.snapshot(), roomy.snapshot()), 2e-3) << random.note();
  EXPECT_LE(differing_nodes(tight.snapshot(), roomy.snapshot()), 3) << random.note();
  EXPECT_EQ(test::disagreeing(tight), 0) << random.note();
  // Material outside the base counts in the hash.
  const Snapshot before = tight.snapshot();
  Removed added;
  const Pose outside{kMiddle - Vec3(60, 60, 60)};
  deposit(tight, SweptTool(BallTool{3}, outside, Vec3::Zero(), tight.lattice()).solid(), 0, {},
          added);
  ASSERT_GT(added.volume(), 0);
  EXPECT_NE(tight.content_hash(), before.content_hash());
  // The smallest lattice that holds the material keeps everything.
  TriDexel fitted(before, LatticeBox());
  fitted.set_lattice(fitted_lattice(before));
  EXPECT_TRUE(fitted.lattice().grown());
  EXPECT_TRUE(same_spans(fitted.snapshot(), before));
  EXPECT_EQ(fitted.content_hash(), before.content_hash());
}

// Material that was added below the base, along all three axes, can be removed again.
TEST(Growth, CutsWhatIsBelowTheBase) {
  Random random;
  SCOPED_TRACE(random.note());
  TriDexel model = ball_in(around_ball(0));
  ASSERT_TRUE(model.grow_to({around_ball(0).whole().units.grown(kMargin)}));
  const uint64_t before = model.content_hash();
  for (int i = 0; i < 40; i++) {
    // The lump is outside the ball. Its tiles also hold parts of the ball, which are inside the
    // base.
    Vec3 centre = kMiddle + random.in_box(-12, 12);
    centre[random.integer(0, 2)] = random.uniform(-40, -14);
    const auto lump = [&](double radius) {
      const Mat3 frame = frame_from_axis(random.direction());
      return SweptTool(BallTool{radius}, {centre - radius * frame.col(2), frame}, Vec3::Zero(),
                       model.lattice());
    };
    Removed added, removed;
    deposit(model, lump(6).solid(), 0, {}, added);
    EXPECT_EQ(test::disagreeing(model), 0);
    cut(model, lump(6.5).solid(), {}, removed);
    EXPECT_NEAR(removed.volume(), added.volume(), 1e-6 * added.volume());
    EXPECT_EQ(test::disagreeing(model), 0);
  }
  EXPECT_EQ(model.content_hash(), before);
}

TEST(Growth, StopsAtTheLimit) {
  Lattice lattice;
  lattice.nodes = Index3(8000, 3, 3);
  TriDexel model(lattice);
  EXPECT_TRUE(model.grow_to({{Vec3(-1e9, 0, 0), Vec3(1e300, 3, 3)}}));
  const Index3 size = model.lattice().high() - model.lattice().low();
  EXPECT_LE(size[0], kMaxNodesPerAxis);
  EXPECT_GT(size[0], kMaxNodesPerAxis - 2 * kTileSide);
  EXPECT_EQ(size[1], 3);
  EXPECT_FALSE(model.grow_to({{Vec3(-1e9, 0, 0), Vec3(1e9, 3, 3)}}));
}

// A surface that follows its model equals a new one, also when the lattice grew or shrank. It does
// not depend on how far the lattice grew beyond the material.
TEST(Growth, ASurfaceFollows) {
  TriDexel model = ball_in(around_ball(0));
  LiveSurface live(model.snapshot());
  const Snapshot before = model.snapshot();
  const auto check = [&] {
    const Snapshot now = model.snapshot();
    live.update(now);
    EXPECT_EQ(test::broken(extract_surface(now)), "");
    TriDexel fitted(now, LatticeBox());
    fitted.set_lattice(fitted_lattice(now));
    const LiveSurface of_all(now), of_fitted(fitted.snapshot());
    const ChunkRange range = surface_chunks(joined(now.lattice, before.lattice));
    for (const LiveSurface* const other : {&of_all, &of_fitted})
      for (int z = range.low[2] - 1; z <= range.high[2]; z++)
        for (int y = range.low[1] - 1; y <= range.high[1]; y++)
          for (int x = range.low[0] - 1; x <= range.high[0]; x++) {
            const SurfaceChunk& fresh = other->chunk({x, y, z});
            const SurfaceChunk& shown = live.chunk({x, y, z});
            ASSERT_EQ(shown.triangles, fresh.triangles);
            ASSERT_EQ(shown.vertices.size(), fresh.vertices.size());
            for (size_t i = 0; i < fresh.vertices.size(); i++)
              ASSERT_EQ(shown.vertices[i].position, fresh.vertices[i].position);
          }
  };
  for (const double reach : {10.0, 100.0, 700.0}) {
    const Vec3 to = kMiddle - Vec3(reach, 0.3 * reach, -0.1 * reach);
    const Box path = Box{to.cwiseMin(kMiddle), to.cwiseMax(kMiddle)}.grown(20);
    model.grow_to(model.lattice().to_lattice(path));
    Removed added;
    deposit(model, SweptTool(BallTool{3}, {kMiddle}, Vec3(to - kMiddle), model.lattice()).solid(),
            0, {}, added);
    check();
  }
  model.restore(before);
  check();
}

// ---- Strokes

struct Path {
  Mode mode;
  Tool tool;
  Brush brush;
  Vec3 to;  // end of the path, from the top of the ball
  int ticks = 40;
  bool back = false, stays = false;  // back: returns to the top. stays: needs no room
};

std::vector<Path> paths() {
  const Brush wide{8, 1, Falloff::smooth, 0};
  return {{Mode::grab, BallTool{4}, wide, Vec3(4, 3, 30)},
          {Mode::grab_connected, BallTool{4}, wide, Vec3(0, -5, 25)},
          {Mode::snake_hook, BallTool{4}, wide, Vec3(10, 0, 28)},
          {Mode::nudge, BallTool{4}, wide, Vec3(6, 0, 0), 40, false, true},
          {Mode::inflate, BallTool{4}, {8, 1, Falloff::smooth, 2}, Vec3(3, 0, 6), 60, true},
          {Mode::build, BallTool{4}, {9, 1, Falloff::smooth, 4}, Vec3(3, 0, 8), 60, true},
          {Mode::crease, BallTool{4}, {6, -1, Falloff::smooth, 0}, Vec3(4, 0, 2), 60, true, true},
          {Mode::node, BallTool{4}, {3, 1, Falloff::smooth, 0}, Vec3(0, 0, 14)},
          {Mode::deposit, BallTool{6}, {}, Vec3(5, 5, 30)}};
}

struct Played {
  double removed_mm3 = 0;
  bool clipped = false;
  std::vector<RecordedTick> ticks;
};

StrokeSettings settings_of(const Path& path, const Lattice& lattice) {
  StrokeSettings s;
  s.mode = path.mode;
  s.tool = path.tool;
  s.brush = path.brush;
  s.force.law.model = ForceModel::energy;
  s.begin_on(lattice);
  return s;
}

// `turn`: rotation of the path about the ball's centre.
Played play(TriDexel& model, const Path& path, const StrokeSettings& settings,
            const Mat3& turn = Mat3::Identity()) {
  const Pose start{kMiddle + turn * Vec3(0, 0, kBall), turn};
  StrokePlayer player(model, start, settings.force.spring);
  Played played;
  const Status begun = player.begin(settings);
  EXPECT_TRUE(begun.ok()) << begun.error();
  ToolTick last;
  for (int i = 1; i <= path.ticks; i++) {
    const double at = static_cast<double>(i) / path.ticks,
                 share = path.back ? 1 - std::fabs(2 * at - 1) : at;
    const Result<ToolTick> tick = player.move(start.tip + share * (turn * path.to), Vec3::Zero());
    EXPECT_TRUE(tick.ok()) << tick.error();
    if (!tick) return played;
    last = tick.value();
    played.ticks.push_back(player.recorded());
    played.clipped |= last.clipped;
    if (i < path.ticks) played.removed_mm3 += last.removed_mm3;
  }
  const auto ended = player.end(last);
  EXPECT_TRUE(ended.ok());
  if (ended.value()) played.ticks.push_back(*ended.value());
  played.removed_mm3 += last.removed_mm3;
  return played;
}

// The same stroke in a lattice that must grow, and in one that has room from the beginning.
TEST(Growth, StrokesAreThoseOfARoomyLattice) {
  const std::array<Mat3, 3> turns{Mat3::Identity(), rotation(Vec3(0, -2.2, 0)),
                                  rotation(Vec3(2.5, 0.4, 0))};
  for (const Path& path : paths())
    for (const Mat3& turn : turns) {
      SCOPED_TRACE(name_of(path.mode));
      TriDexel tight = ball_in(around_ball(0)), roomy = ball_in(around_ball(kMargin));
      const double before = roomy.volume_mm3();
      const Played one = play(tight, path, settings_of(path, tight.lattice()), turn),
                   other = play(roomy, path, settings_of(path, roomy.lattice()), turn);
      EXPECT_FALSE(one.clipped);
      EXPECT_FALSE(other.clipped);
      EXPECT_FALSE(roomy.lattice().grown());
      const bool grew = tight.lattice().grown();
      EXPECT_NE(grew, path.stays);
      EXPECT_NE(roomy.volume_mm3(), before);
      EXPECT_NEAR(tight.volume_mm3(), roomy.volume_mm3(),
                  2e-3 * std::fabs(roomy.volume_mm3() - before) + 0.5);
      const Surface a = extract_surface(tight.snapshot()), b = extract_surface(roomy.snapshot());
      const auto off = two_sided_distance(a, b, 50000);
      ASSERT_TRUE(off.ok());
      EXPECT_LT(off.value().rms(), 0.02);
      EXPECT_LT(differing_rays(tight.snapshot(), roomy.snapshot()), 5e-3);
      // Where the surface passes exactly through a node, rounding decides.
      EXPECT_LE(differing_nodes(tight.snapshot(), roomy.snapshot()), 20);
    }
}

// Without permission, as in older documents, strokes are cut off at the border.
TEST(Growth, OlderStrokesAreCutOff) {
  for (const Path& path : paths()) {
    if (path.stays) continue;
    SCOPED_TRACE(name_of(path.mode));
    TriDexel model = ball_in(around_ball(0));
    StrokeSettings settings = settings_of(path, model.lattice());
    settings.grows = false;
    EXPECT_TRUE(play(model, path, settings).clipped);
    EXPECT_FALSE(model.lattice().grown());
  }
}

// At the limit of nodes, a stroke is cut off and says so. Nothing else is lost.
TEST(Growth, AStrokeAtTheLimitIsCutOff) {
  Lattice lattice = around_ball(0);
  lattice.nodes[2] = kMaxNodesPerAxis - 8;
  lattice.origin_mm[2] = -(kMaxNodesPerAxis - 8 - 42.0);  // the ball is at the upper end
  TriDexel model = ball_in(lattice);
  const double before = model.volume_mm3();
  const Path up{Mode::grab, BallTool{4}, {8, 1, Falloff::smooth, 0}, Vec3(0, 0, 20)};
  const Played played = play(model, up, settings_of(up, model.lattice()));
  EXPECT_TRUE(played.clipped);
  EXPECT_GT(model.volume_mm3(), before);
  EXPECT_LE((model.lattice().high() - model.lattice().low()).maxCoeff(), kMaxNodesPerAxis);
}

// ---- Documents

void record(Document& document, TriDexel& model, const Path& path, const Mat3& turn) {
  const StrokeSettings settings = settings_of(path, model.lattice());
  ASSERT_TRUE(document.begin(settings, {kMiddle + turn * Vec3(0, 0, kBall), turn}).ok());
  const Played played = play(model, path, settings, turn);
  for (const RecordedTick& tick : played.ticks) document.add(tick);
  ASSERT_TRUE(document.finish(model, played.removed_mm3).ok());
}

TEST(Growth, DocumentsRepeatIt) {
  Random random;
  Folder folder;
  const std::filesystem::path file = folder.path / "grown.kibori";
  TriDexel model = ball_in(around_ball(0));
  std::vector<uint64_t> hashes{model.content_hash()};
  std::vector<Snapshot> states{model.snapshot()};
  {
    auto document = test::created(file, model);
    for (const Path& path : paths()) {
      record(*document, model, path, rotation(3 * random.direction()));
      hashes.push_back(model.content_hash());
      states.push_back(model.snapshot());
    }
    EXPECT_TRUE(model.lattice().grown());
    // Undo and redo across growth, with the states in memory.
    for (size_t i = hashes.size() - 1; i-- > 0;) {
      ASSERT_TRUE(document->undo(model).ok());
      EXPECT_EQ(model.content_hash(), hashes[i]);
      EXPECT_TRUE(same_spans(model.snapshot(), states[i]));
    }
    EXPECT_FALSE(model.lattice().grown());
    for (size_t i = 1; i < hashes.size(); i++) {
      ASSERT_TRUE(document->redo(model).ok());
      EXPECT_EQ(model.content_hash(), hashes[i]);
    }
    // A branch from the middle.
    ASSERT_TRUE(document->go(model, 3).ok());
    record(*document, model, paths().front(), rotation(Vec3(1, 1, 0)));
    EXPECT_EQ(test::wrongs(*document), std::vector<std::string>());
  }
  // Reads the file: by its stored tiles, and by a replay of all strokes.
  auto document = test::opened(file);
  ASSERT_TRUE(document);
  const uint64_t branch = model.content_hash();
  auto loaded = document->load();
  ASSERT_TRUE(loaded.ok()) << loaded.error();
  EXPECT_EQ(loaded.value()->content_hash(), branch);
  for (size_t i = hashes.size(); i-- > 0;) {
    ASSERT_TRUE(document->go(*loaded.value(), static_cast<StepId>(i + 1)).ok());
    EXPECT_EQ(loaded.value()->content_hash(), hashes[i]) << random.note();
    EXPECT_TRUE(same_spans(loaded.value()->snapshot(), states[i]));
  }
  // Carving continues from a loaded state, in another lattice than before.
  ASSERT_TRUE(document->go(*loaded.value(), 2).ok());
  record(*document, *loaded.value(), paths()[4], rotation(Vec3(0, 1, 0)));
  EXPECT_EQ(test::wrongs(*document), std::vector<std::string>());
}

TEST(Growth, BodiesThatOutgrewTheBaseCanBeJoined) {
  Folder folder;
  TriDexel model = ball_in(around_ball(0));
  auto document = test::created(folder.path / "bodies.kibori", model);
  record(*document, model, paths().back(), Mat3::Identity());
  const auto act = [&](const BodyAction& action) {
    const auto done = document->act(action);
    ASSERT_TRUE(done.ok()) << done.error();
  };
  Cutter cutter;
  cutter.shape = CutPlane{kMiddle + Vec3(0, 0, 20), Vec3(0.1, 0, 1)};
  act({{}, BodyCut{cutter}});
  ASSERT_EQ(document->bodies_at(document->head()).all.size(), 2u);
  const double volume = document->worked_on()->volume_mm3();
  act({{1, 2}, BodyJoin{}});
  EXPECT_NEAR(document->worked_on()->volume_mm3(), volume, 1e-3 * volume);
  EXPECT_EQ(test::wrongs(*document), std::vector<std::string>());
}

// ---- By hand

// The hand drags the block's surface far beyond its room, with every mode that adds material.
std::unique_ptr<LiveCarving> far_hand() {
  VirtualDeviceSettings device;
  device.capabilities = test::arm();
  device.capabilities.dof_out = 0;
  device.count_mm = 0;
  LiveSettings settings;
  settings.mode = Mode::off;
  settings.tool = BallTool{2};
  settings.model = ForceModel::energy;  // its tool is where the hand is
  settings.brush = {4, 1, Falloff::smooth, 0};
  settings.log = true;
  settings.crumbs = Crumbs::stay;  // the hash of a step is that of all bodies
  return std::move(test::rig(device, settings, [](double t) {
                     return VirtualDevice::Target{
                         Vec3(15 * std::sin(3 * t), 11 * std::cos(2 * t), 8 + 14 * std::cos(7 * t)),
                         Mat3::Identity(), 0};
                   }).live);
}

constexpr std::array kGrowing{Mode::grab, Mode::deposit, Mode::snake_hook, Mode::inflate};

// Waits until all of the previous stroke is in the model, then chooses a mode. Returns the model's
// hash.
uint64_t choose(LiveCarving& live, Mode mode) {
  bool over = false;
  uint64_t hash = 0;
  live.post([&over, &hash, mode](ServoContext& c) {
    hash = c.model().content_hash();
    c.settings().mode = mode;
    over = true;
  });
  while (!over) {
    live.tick(0.001);
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  return hash;
}

TEST(Growth, AHandRecordsIt) {
  Folder folder;
  const auto live = far_hand();
  auto document = Document::create(folder.path / "hand.kibori", live->context().model(), "{}");
  ASSERT_TRUE(document.ok());
  DocumentWriter writer(*live, std::move(document).value());
  live->context().safety().arm();
  bool clipped = false;
  for (int i = 0; i < 12; i++) {
    const uint64_t hash = choose(*live, kGrowing[static_cast<size_t>(i) % kGrowing.size()]);
    writer.write();
    const Document& so_far = writer.document();
    EXPECT_EQ(so_far.steps().at(so_far.head()).hash, hash) << "round " << i;
    for (int k = 0; k < 250; k++) {
      clipped |= live->tick(0.001).clipped;
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    writer.write();
  }
  live->context().finish_stroke();
  writer.write();
  EXPECT_FALSE(clipped);
  EXPECT_TRUE(live->context().model().lattice().grown());
  EXPECT_EQ(writer.write_error(), "");
  const Document& after = writer.document();
  EXPECT_GT(after.steps().size(), 8u);
  EXPECT_EQ(after.steps().at(after.head()).hash, live->context().model().content_hash());
  EXPECT_EQ(test::wrongs(after), std::vector<std::string>());
}

// kill -9 during strokes that grow. The file holds an exact beginning of the work.
TEST(Growth, AKilledProcessLeavesAnExactBeginning) {
  Random random;
  Folder folder;
  const std::filesystem::path file = folder.path / "k.kibori";
  struct Witness {
    std::atomic<int> commits{0}, strokes{0};
    std::array<uint64_t, 1000> hashes;
  };
  auto* const witness = static_cast<Witness*>(
      mmap(nullptr, sizeof(Witness), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(witness, MAP_FAILED);
  const int kills = test::rounds_of("KIBORI_GROWTH_KILLS", 3);
  for (int round = 0; round < kills; round++) {
    for (const char* rest : {"", "-wal", "-shm"}) std::filesystem::remove(file.string() + rest);
    new (witness) Witness{};
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const auto live = far_hand();
      auto document = Document::create(file, live->context().model(), "{}");
      if (!document) _exit(1);
      DocumentWriter writer(*live, std::move(document).value());
      writer.start();
      live->context().safety().arm();
      for (int i = 0; i < 999; i++) {
        witness->hashes[static_cast<size_t>(witness->strokes.load())] =
            choose(*live, kGrowing[static_cast<size_t>(i) % kGrowing.size()]);
        witness->strokes++;
        for (int k = 0; k < 150; k++) {
          witness->commits += live->tick(0.001).cutting;
          std::this_thread::sleep_for(std::chrono::microseconds(300));
        }
      }
      _exit(0);
    }
    const int until = random.integer(10, 200);
    for (int i = 0; i < 60000 && witness->commits < until; i++)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "round " << round << ", " << random.note();
    auto document = test::opened(file);
    ASSERT_TRUE(document) << random.note();
    EXPECT_EQ(test::wrongs(*document), std::vector<std::string>()) << random.note();
    // The hashes of all finished strokes except the last are hashes of the process.
    std::vector<uint64_t> hashes;
    for (const auto& [id, step] : document->steps()) hashes.push_back(step.hash);
    size_t next = 0;
    for (size_t i = 1; i + 1 < hashes.size(); i++) {
      while (next < static_cast<size_t>(witness->strokes.load()) &&
             witness->hashes[next] != hashes[i])
        next++;
      EXPECT_LT(next, static_cast<size_t>(witness->strokes.load()))
          << "step " << i << ", " << random.note();
    }
  }
  munmap(witness, sizeof(Witness));
}

}  // namespace
}  // namespace kibori::growth_tests
