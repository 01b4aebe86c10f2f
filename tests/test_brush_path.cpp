// SPDX-License-Identifier: MIT
// A brush follows the whole path of the hand, even if its dabs are slow. Tests of merged poses, of
// a worker that is late, and of strokes that are discarded meanwhile.
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <numbers>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/devices/pointer_device.h>
#include <kibori/live/document_writer.h>
#include <kibori/live/pose_merger.h>
#include <kibori/motion/direct_tool.h>

#include "tests/document_support.h"
#include "tests/live_rig.h"
#include "tests/modes.h"
#include "tests/support.h"

namespace kibori::brush_path_tests {
namespace {

using test::Folder;
using test::Random;

constexpr double kPitch = 1;

// ---- PoseMerger

// Distance of a point from the path through `corners`.
double distance_from(const std::vector<Vec3>& corners, const Vec3& point) {
  double nearest = (point - corners.front()).norm();
  for (size_t i = 1; i < corners.size(); i++) {
    const Vec3 way = corners[i] - corners[i - 1];
    const double share =
        way.squaredNorm() > 0
            ? std::clamp((point - corners[i - 1]).dot(way) / way.squaredNorm(), 0.0, 1.0)
            : 0;
    nearest = std::min(nearest, (point - corners[i - 1] - share * way).norm());
  }
  return nearest;
}

// The corners that remain of a path.
std::vector<Pose> merged(const std::vector<Pose>& path, double tolerance, double reach = 0) {
  std::vector<Pose> corners{path.front()};
  PoseMerger merger;
  merger.begin(path.front(), tolerance, reach);
  for (const Pose& pose : path) {
    if (merger.add(pose)) continue;
    corners.push_back(merger.end());
    merger.begin(corners.back(), tolerance, reach);
    EXPECT_TRUE(merger.add(pose));
  }
  corners.push_back(merger.end());
  return corners;
}

std::vector<Vec3> tips(const std::vector<Pose>& poses) {
  std::vector<Vec3> all;
  for (const Pose& pose : poses) all.push_back(pose.tip);
  return all;
}

double length_of(const std::vector<Vec3>& corners) {
  double length = 0;
  for (size_t i = 1; i < corners.size(); i++) length += (corners[i] - corners[i - 1]).norm();
  return length;
}

TEST(PoseMerger, MergesAStraightMotion) {
  std::vector<Pose> path;
  for (int i = 0; i < 30; i++) path.push_back({Vec3(0.1 * i * i, 0.2 * i * i, 0)});
  EXPECT_EQ(merged(path, 0.05).size(), 2u);
  // A hand at rest adds no poses.
  EXPECT_EQ(merged(std::vector<Pose>(1000, Pose{Vec3(1, 2, 3)}), 0.05).size(), 2u);
}

TEST(PoseMerger, KeepsCornersAndTheWayBack) {
  std::vector<Pose> path;
  for (int i = 0; i <= 20; i++) path.push_back({Vec3(i, 0, 0)});
  for (int i = 1; i <= 20; i++) path.push_back({Vec3(20, i, 0)});
  for (int i = 1; i <= 20; i++) path.push_back({Vec3(20, 20 - i, 0)});
  const std::vector<Vec3> corners = tips(merged(path, 0.05));
  ASSERT_EQ(corners.size(), 4u);
  EXPECT_EQ(corners[1], Vec3(20, 0, 0));
  EXPECT_EQ(corners[2], Vec3(20, 20, 0));
  EXPECT_EQ(corners[3], Vec3(20, 0, 0));
}

TEST(PoseMerger, StaysWithinTheTolerance) {
  Random random;
  for (int round = 0; round < 200; round++) {
    const double tolerance = random.uniform(0.01, 0.2), size = random.uniform(0.1, 20);
    std::vector<Pose> path;
    for (int i = 0; i < 300; i++) {
      const double t = 0.02 * i;
      path.push_back({Vec3(size * std::sin(t), size * std::cos(1.3 * t), 0.3 * size * t) +
                      0.3 * tolerance * random.direction()});
    }
    const std::vector<Vec3> corners = tips(merged(path, tolerance));
    EXPECT_EQ(corners.back(), path.back().tip);
    for (const Pose& pose : path) EXPECT_LE(distance_from(corners, pose.tip), tolerance + 1e-9);
  }
}

// The pressure of a pen changes evenly along a merged motion.
TEST(PoseMerger, KeepsPressures) {
  PoseMerger merger;
  merger.begin({Vec3(0, 0, 0)}, 0.05, 0, 0);
  for (int i = 1; i <= 10; i++) EXPECT_TRUE(merger.add({Vec3(i, 0, 0)}, 0.1 * i));
  EXPECT_EQ(merger.end_pressure(), 1);
  EXPECT_FALSE(merger.add({Vec3(11, 0, 0)}, 0.5));
}

// A tool that turns on the spot, or along a straight line: points at its reach stay within the
// tolerance.
TEST(PoseMerger, KeepsTurns) {
  const double reach = 10, tolerance = 0.05;
  for (const double speed : {0.0, 0.3}) {
    std::vector<Pose> path;
    for (int i = 0; i < 100; i++) {
      const double angle = 0.4 * std::sin(0.1 * i);
      path.push_back({Vec3(speed * i, 0, 0), rotation(Vec3(angle, 0, 0))});
    }
    EXPECT_LE(merged(path, tolerance).size(), 2u + path.size() / PoseMerger::kMaxPoses);
    const std::vector<Pose> corners = merged(path, tolerance, reach);
    EXPECT_LT(corners.size(), path.size());
    std::vector<Vec3> ends;
    for (size_t i = 1; i < corners.size(); i++) {
      const ToolMotion motion{corners[i - 1], corners[i].tip - corners[i - 1].tip,
                              rotation_between(corners[i - 1].frame, corners[i].frame)};
      for (int k = 0; k <= 20; k++) ends.push_back(motion.at(k / 20.0).to_world({0, reach, 0}));
    }
    for (const Pose& pose : path)
      EXPECT_LE(distance_from(ends, pose.to_world({0, reach, 0})), 1.1 * tolerance);
  }
}

// ---- A slow worker

// Holds the dab worker in the middle of its first dab.
struct Gate {
  std::atomic<bool> shut{true};
  std::function<void()> hook() {
    return [this] {
      while (shut) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
  }
};

LiveSettings brush_settings(Mode mode) {
  LiveSettings settings;
  settings.mode = mode;
  settings.tool = BallTool{4};
  settings.brush = {6, 0.5, Falloff::smooth, 0};
  settings.log = true;
  return settings;
}

// The block with a hollow in its top, so that every brush has something to do.
std::unique_ptr<TriDexel> hollowed() {
  std::unique_ptr<TriDexel> model = test::block(kPitch);
  DirectTool tool(*model, {Vec3(29, 15, 30)});
  EXPECT_TRUE(tool.advance(BallTool{5}, Vec3(29, 15, 16), Vec3::Zero(), Mode::cut,
                           {ForceModel::energy, 6}, {Material{}}, 0)
                  .ok());
  return model;
}

// A hand that is exactly where its script says [mm from the device's centre], and cannot wait.
class ScriptedDevice final : public Device {
 public:
  using Script = std::function<Vec3(double)>;
  ScriptedDevice(Script script, double speed_mm_s) : script_(std::move(script)) {
    capabilities_ = test::arm();
    capabilities_.dof_out = 0;
    capabilities_.damping_ns_mm = 1000;
    capabilities_.speed_mm_s = speed_mm_s;
  }
  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  DeviceStatus read(DeviceReading& reading) override {
    reading.position_mm = script_(0.001 * static_cast<double>(reads_++));
    return DeviceStatus::ok;
  }
  DeviceStatus write(const Wrench&) override { return DeviceStatus::ok; }

 private:
  DeviceCapabilities capabilities_;
  Script script_;
  long reads_ = 0;
};

// A scripted hand over the block. The device's centre is 5 mm above the middle of its top.
std::unique_ptr<LiveCarving> by_device(LiveSettings settings, ScriptedDevice::Script script,
                                       double speed_mm_s = 1e6) {
  settings.workspace = Workspace(Vec3(20, 15, 25));
  auto live = LiveCarving::make(
      hollowed(), std::make_unique<ScriptedDevice>(std::move(script), speed_mm_s), settings);
  EXPECT_TRUE(live.ok()) << live.error();
  return std::move(live).value();
}

// A circle on the block's top, in 0.3 s.
Vec3 circle(double t) {
  const double angle = 2 * std::numbers::pi * std::min(t / 0.3, 1.0);
  return {9 * std::cos(angle), 9 * std::sin(angle), -5.5};
}

// Runs some ticks and returns the tool's poses. The result does not depend on the real time between
// ticks.
std::vector<Pose> run(LiveCarving& live, int ticks) {
  std::vector<Pose> poses;
  for (int i = 0; i < ticks; i++) poses.push_back(live.tick_at_once(0.001).tool);
  return poses;
}

// Brushes along the same path without a worker thread. Returns the model's hash.
uint64_t played(const LiveSettings& settings, const std::vector<Pose>& poses) {
  const std::unique_ptr<TriDexel> model = hollowed();
  ReshapeStroke stroke(*model);
  EXPECT_TRUE(stroke
                  .begin({settings.mode,
                          settings.brush,
                          settings.tool,
                          {ForceModel::series, 6},
                          settings.rate_hz,
                          settings.symmetry},
                         settings.materials, poses.front())
                  .ok());
  Pose last = poses.front();
  ToolTick tick;
  for (const Pose& pose : poses) {
    tick =
        moved_tick({last, pose.tip - last.tip, rotation_between(last.frame, pose.frame)}, pose.tip);
    EXPECT_TRUE(stroke.advance(tick, true).ok());
    last = pose;
  }
  if (ends_apart(settings.mode)) {
    EXPECT_TRUE(stroke.end(tick).ok());
  }
  return model->content_hash();
}

void expect_document(LiveCarving& live, const std::function<void()>& act,
                     const std::function<void(const Document&)>& see) {
  Folder folder;
  auto document = Document::create(folder.path / "a.kibori", live.context().model(), "{}");
  ASSERT_TRUE(document.ok()) << document.error();
  DocumentWriter writer(live, std::move(document).value());
  act();
  live.context().finish_stroke();
  writer.write();
  EXPECT_EQ(writer.write_error(), "");
  const Document& after = writer.document();
  EXPECT_EQ(after.steps().at(after.head()).hash, live.context().model().content_hash());
  EXPECT_TRUE(after.verify([](const std::string& wrong) { ADD_FAILURE() << wrong; }).ok());
  see(after);
}

std::vector<Vec3> recorded_path(const Document& document, StepId step) {
  const Result<Pose> start = document.start(step);
  EXPECT_TRUE(start.ok());
  std::vector<Vec3> path{start.value().tip};
  EXPECT_TRUE(document
                  .for_ticks(step,
                             [&](const std::vector<RecordedTick>& ticks) -> Status {
                               for (const RecordedTick& tick : ticks)
                                 path.push_back(test::tip_of(tick));
                               return Ok{};
                             })
                  .ok());
  return path;
}

// For each mode whose result depends on the path, a worker that is late makes the same model.
TEST(BrushPath, SlowDabsMakeTheSameModel) {
  for (const Mode mode : test::reshaping_modes()) {
    if (warps(mode)) continue;
    LiveSettings settings = brush_settings(mode);
    const auto pause = std::chrono::milliseconds(mode == Mode::crease ? 200 : 20);
    settings.after_dab = [pause] { std::this_thread::sleep_for(pause); };
    if (mode == Mode::paint) settings.brush.color = {200, 10, 10};
    const auto live = by_device(settings, circle);
    expect_document(
        *live,
        [&] {
          const std::vector<Pose> poses = run(*live, 320);
          live->context().finish_stroke();
          EXPECT_EQ(live->context().model().content_hash(), played(settings, poses))
              << name_of(mode);
        },
        [&](const Document& document) {
          // A stroke that changes nothing makes no step.
          const bool changed = live->context().model().content_hash() != hollowed()->content_hash();
          EXPECT_EQ(document.steps().size(), changed ? 2u : 1u) << name_of(mode);
          std::printf("%s %s\n", std::string(name_of(mode)).c_str(),
                      changed ? "works" : "changes nothing");
        });
  }
}

// The first dab of a texture waits for the direction of the path. A slow hand gets it, too: there,
// each tick is much shorter than the distance of two dabs.
TEST(BrushPath, ATextureFollowsAHandOfAnySpeed) {
  auto picture = std::make_shared<AlphaPicture>();
  picture->greys.fill(255);
  for (const Mode mode : {Mode::inflate, Mode::paint, Mode::smooth})
    for (const Alpha alpha : {Alpha::none, Alpha::studs, Alpha::picture})
      for (const double slower : {1.0, 10.0}) {
        const std::string what = std::string(name_of(mode)) + " " + std::string(name_of(alpha)) +
                                 " " + std::to_string(slower);
        LiveSettings settings = brush_settings(mode);
        settings.brush.alpha = alpha;
        if (alpha == Alpha::picture) settings.brush.picture = picture;
        settings.brush.color = {200, 10, 10};
        const auto live = by_device(settings, [slower](double t) { return circle(t / slower); });
        expect_document(
            *live,
            [&] {
              run(*live, static_cast<int>(slower) * 320);
              live->context().finish_stroke();
            },
            [&](const Document& document) {
              ASSERT_EQ(document.steps().size(), 2u) << what;
              const std::vector<Vec3> path = recorded_path(document, 2);
              EXPECT_NEAR(length_of(path), 2 * std::numbers::pi * 9, 2) << what;
            });
      }
}

// The result of a warp depends only on its last pose.
TEST(BrushPath, ASlowWarpEndsAtTheHand) {
  Gate gate;
  LiveSettings settings = brush_settings(Mode::grab);
  settings.after_dab = gate.hook();
  const auto live =
      by_device(settings, [](double t) { return Vec3(4 * std::min(t / 9, 1.0), 0, -5); });
  std::vector<Pose> poses;
  expect_document(
      *live,
      [&] {
        poses = run(*live, static_cast<int>(DabWorker::kMaxMoves) + 1000);
        gate.shut = false;
      },
      [&](const Document& document) {
        EXPECT_EQ(recorded_path(document, 2).back(), poses.back().tip);
        EXPECT_EQ(live->context().model().content_hash(),
                  played(settings, {poses.front(), poses.back()}));
      });
}

// A pointer waits for its brush. So a path that is longer than the queue is exact, too.
TEST(BrushPath, APointerWaits) {
  LiveSettings settings = brush_settings(Mode::inflate);
  settings.workspace = Workspace();
  settings.brush.spacing = 1;
  std::vector<uint64_t> hashes;
  for (const bool slow : {false, true}) {
    Gate gate;
    gate.shut = slow;
    settings.after_dab = gate.hook();
    auto made = std::make_unique<PointerDevice>(settings.rate_hz);
    PointerDevice* const pointer = made.get();
    auto live = LiveCarving::make(test::block(kPitch), std::move(made), settings);
    ASSERT_TRUE(live.ok()) << live.error();
    ServoContext& context = live.value()->context();
    // A square of 12 s.
    const Vec3 corners[] = {{10, 8, 19}, {30, 8, 19}, {30, 22, 19}, {10, 22, 19}, {10, 8, 19}};
    const uint32_t stroke = pointer->begin({corners[0]}, 0);
    for (int i = 1; i <= 1200; i++) {
      const int side = (i - 1) / 300;
      const double share = (i - 300 * side) / 300.0;
      pointer->move({corners[side] + share * (corners[side + 1] - corners[side])}, 0.01 * i);
    }
    pointer->end();
    context.place_at({corners[0]});
    pointer->follow(stroke, {corners[0]});
    const auto tick = [&] {
      pointer->pump();
      return live.value()->tick_at_once(0.001).pending;
    };
    size_t largest = 0;
    for (int i = 0; slow && i < 20000; i++) largest = std::max(largest, tick());
    if (slow) {
      EXPECT_LT(pointer->finished(), stroke);
      EXPECT_EQ(largest, DabWorker::kMaxMoves / 2);
    }
    gate.shut = false;
    while (pointer->finished() < stroke) tick();
    context.finish_stroke();
    hashes.push_back(context.model().content_hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_NE(hashes[0], test::block(kPitch)->content_hash());
}

// A force device's hand cannot wait for slow dabs. Its path is merged, and no corner is lost. The
// document contains the merged path.
TEST(BrushPath, ALongPathOfADeviceKeepsItsCorners) {
  for (const Mode mode : {Mode::inflate, Mode::press}) {
    Gate gate;
    LiveSettings settings = brush_settings(mode);
    settings.brush = {8, 0.05, Falloff::smooth, 0};
    settings.after_dab = gate.hook();
    // Squares, and circles that become smaller.
    const auto script = [](double t) {
      const double size = 9 - 0.3 * t;
      const int side = static_cast<int>(t / 0.5) % 4;
      const double at = 2 * (t / 0.5 - std::floor(t / 0.5)) - 1;
      const Vec3 square = side == 0   ? Vec3(at, -1, 0)
                          : side == 1 ? Vec3(1, at, 0)
                          : side == 2 ? Vec3(-at, 1, 0)
                                      : Vec3(-1, -at, 0);
      const Vec3 round(std::cos(3 * t), std::sin(3 * t), 0);
      return Vec3(size * (t < 8 ? square : round) + Vec3(0, 0, -5.2));
    };
    const auto live = by_device(settings, script);
    std::vector<Pose> poses;
    expect_document(
        *live,
        [&] {
          poses = run(*live, 16000);
          gate.shut = false;
        },
        [&](const Document& document) {
          ASSERT_EQ(document.steps().size(), 2u);
          const std::vector<Vec3> path = recorded_path(document, 2);
          EXPECT_LT(path.size(), poses.size());
          EXPECT_EQ(path.back(), poses.back().tip);
          for (size_t i = 0; i < poses.size(); i += 7)
            EXPECT_LE(distance_from(path, poses[i].tip), DabWorker::kMergeTolerance * kPitch + 1e-9)
                << i;
          EXPECT_NEAR(length_of(path), length_of(tips(poses)), 5e-3 * length_of(path));
        });
  }
}

// A path is longer than the queue, and its poses cannot be merged. The stroke ends when the queue
// is full, and a new one begins later. No corner is skipped.
TEST(BrushPath, AStrokeWithoutRoomEnds) {
  Gate gate;
  LiveSettings settings = brush_settings(Mode::inflate);
  settings.brush = {12, 0.01, Falloff::smooth, 0};
  settings.brush.spacing = 2;
  settings.after_dab = gate.hook();
  const auto live = by_device(settings, [](double t) {
    const double side = std::llround(1000 * t) % 2 ? 0.1 : -0.1;  // a corner in every tick
    return Vec3(-9 + 2 * t, side, -5);
  });
  std::vector<Vec3> path;
  int ended = 0;
  expect_document(
      *live,
      [&] {
        for (size_t i = 0; i < DabWorker::kMaxMoves + 500; i++) {
          const LiveTick tick = live->tick_at_once(0.001);
          if (ended == 0 && !tick.gave_up) path.push_back(tick.tool.tip);
          ended += tick.gave_up;
        }
        EXPECT_EQ(ended, 1);
        gate.shut = false;
      },
      [&](const Document& document) {
        ASSERT_GE(document.steps().size(), 2u);
        EXPECT_EQ(recorded_path(document, 2).back(), path.back());
      });
}

// A device that jumps ends its stroke, but only after all of its path.
TEST(BrushPath, AJumpKeepsThePathBefore) {
  for (const Mode mode : {Mode::inflate, Mode::press}) {
    Gate gate;
    LiveSettings settings = brush_settings(mode);
    settings.after_dab = gate.hook();
    const auto live = by_device(
        settings, [](double t) { return t < 0.3 ? circle(t) : Vec3(-9, 0, -5.5); }, 400);
    std::vector<Pose> poses;
    expect_document(
        *live,
        [&] {
          poses = run(*live, 400);
          gate.shut = false;
        },
        [&](const Document& document) {
          ASSERT_GE(document.steps().size(), 2u);
          size_t before = 0;
          while ((poses[before + 1].tip - poses[before].tip).norm() < 5) before++;
          EXPECT_EQ(recorded_path(document, 2).back(), poses[before].tip);
          EXPECT_EQ(live->totals().jumps, 1u);
        });
  }
}

// A stroke that is discarded while most of it waits leaves no trace. The function that is posted
// with the cancellation runs before the hand's next tick.
TEST(BrushPath, ADiscardedStrokeLeavesNoTrace) {
  for (const bool ends : {false, true})  // a command already waits for the stroke's end
    for (const Mode mode : {Mode::inflate, Mode::press}) {
      Gate gate;
      LiveSettings settings = brush_settings(mode);
      settings.after_dab = gate.hook();
      const auto live = by_device(settings, circle);
      const uint64_t before = live->context().model().content_hash();
      expect_document(
          *live,
          [&] {
            run(*live, 250);
            gate.shut = false;
            while (!live->tick_at_once(0.001).cutting)
              std::this_thread::sleep_for(std::chrono::milliseconds(1));
            gate.shut = true;
            run(*live, 10);
            bool ran = false;
            if (ends) {
              EXPECT_TRUE(live->post([&](ServoContext&) { ran = true; }));
            }
            run(*live, 10);
            EXPECT_TRUE(
                live->cancel_stroke([](ServoContext& c) { c.settings().mode = Mode::off; }));
            run(*live, 1);
            EXPECT_EQ(live->context().model().content_hash(), before);
            gate.shut = false;
            run(*live, 100);
            EXPECT_EQ(ran, ends);
          },
          [&](const Document& document) {
            EXPECT_EQ(document.steps().size(), 1u);
            EXPECT_EQ(live->context().model().content_hash(), before);
          });
      if (mode == Mode::press) continue;  // a hand that rests presses nothing
      // The next stroke works.
      ASSERT_TRUE(live->post([mode](ServoContext& c) { c.settings().mode = mode; }));
      run(*live, 50);
      live->context().finish_stroke();
      EXPECT_NE(live->context().model().content_hash(), before);
    }
}

// A brush that changed nothing reports this at the end of its stroke. Other brushes report nothing.
TEST(BrushPath, ABrushWithNothingToDoReportsIt) {
  for (const Mode mode : {Mode::fill, Mode::rasp, Mode::inflate})
    for (const bool hollow : {false, true}) {
      const auto live = by_device(brush_settings(mode), [hollow](double t) {
        return Vec3((hollow ? 9 : -9) + 2 * std::min(10 * t, 1.0), 0, -5);
      });
      run(*live, 150);
      bool lifted = false;
      ASSERT_TRUE(live->post([&](ServoContext& c) {
        c.settings().mode = Mode::off;
        lifted = true;
      }));
      std::optional<Mode> idle;
      while (!lifted) {
        if (const LiveTick tick = live->tick_at_once(0.001); tick.idle_brush)
          idle = tick.idle_brush;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      const bool changes = mode == Mode::inflate || hollow;
      EXPECT_EQ(idle, changes ? std::nullopt : std::optional<Mode>(mode)) << name_of(mode);
    }
}

}  // namespace
}  // namespace kibori::brush_path_tests
