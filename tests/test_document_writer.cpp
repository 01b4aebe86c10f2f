// SPDX-License-Identifier: MIT
// A hand's carving reaches the document, and the document's history reaches the hand.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <set>
#include <thread>

#include <csignal>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <kibori/live/document_writer.h>

#include "tests/fault_vfs.h"
#include "tests/live_rig.h"
#include "tests/document_support.h"
#include "tests/modes.h"
#include "tests/support.h"

namespace kibori::document_writer_tests {
namespace {

using test::arm;
using test::FaultVfs;
using test::Folder;
using test::Random;
using test::Rig;
using test::rig;

// A hand that moves in and out of the wood while it turns.
Rig busy_rig(ForceModel hand, std::unique_ptr<TriDexel> model = nullptr) {
  VirtualDeviceSettings device;
  device.capabilities = arm();
  LiveSettings settings;
  settings.tool = Finger{0.2, 20};
  settings.model = hand;
  settings.log = true;
  settings.spring.stiffness_n_mm = 1;
  settings.spring.torsion_nmm_rad = 20;
  settings.materials[0].u = 0.02;
  const auto script = [](double t) {
    return VirtualDevice::Target{
        Vec3(8 * std::sin(5 * t), 6 * std::cos(4 * t), -5 + 3 * std::cos(6 * t)),
        rotation(Vec3(0.2 * std::sin(3 * t), 0, 0)), 0};
  };
  return rig(device, settings, script, std::move(model));
}

void expect_sound(const Document& document) {
  EXPECT_TRUE(document.verify([](const std::string& wrong) { ADD_FAILURE() << wrong; }).ok());
}

// The document holds what a hand carved, stroke by stroke. Its replay leaves the same bytes.
TEST(DocumentWriter, KeepsWhatTheHandDoes) {
  for (const ForceModel model : {ForceModel::series, ForceModel::energy})
    for (const bool threads : {false, true}) {
      Folder folder;
      const std::filesystem::path file = folder.path / "live.kibori";
      Rig r = busy_rig(model);
      auto document = Document::create(file, r.live->context().model(), "{}");
      ASSERT_TRUE(document.ok()) << document.error();
      {
        DocumentWriter writer(*r.live, std::move(document).value());
        int done = 0;
        const auto change = [&](ServoContext& live) {
          live.settings().tool = BallTool{2.0 + 0.1 * done++};
          live.settings().materials[0].u = 0.03;
        };
        if (threads) {
          writer.start();
          r.live->start();
          for (int i = 0; i < 5; i++) {
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
            EXPECT_TRUE(r.live->post(change));
          }
          r.live->stop();
          writer.stop();
        } else {
          r.live->context().safety().arm();
          for (int i = 0; i < 3000; i++) {
            if (i % 700 == 699) {
              EXPECT_TRUE(r.live->post(change));
            }
            r.live->tick(0.001);
            if (i % 20 == 0) writer.write();
          }
          r.live->context().finish_stroke();
          writer.write();
        }
        EXPECT_EQ(writer.write_error(), "");
        EXPECT_FALSE(writer.document().in_stroke());
        EXPECT_EQ(writer.document().steps().at(writer.document().head()).hash,
                  r.live->context().model().content_hash());
      }
      auto after = Document::open(file, Document::Access::read);
      ASSERT_TRUE(after.ok()) << after.error();
      // The number of strokes in a second of real time depends on the machine.
      EXPECT_GE(after.value()->steps().size(), threads ? 2u : 3u);
      EXPECT_EQ(after.value()->load().value()->content_hash(),
                r.live->context().model().content_hash());
      double removed = 0;
      for (const auto& [id, step] : after.value()->steps()) removed += step.removed_mm3;
      EXPECT_NEAR(removed, r.live->totals().removed_mm3, 1e-6 * removed);
      expect_sound(*after.value());
    }
}

// Brushes: dabs are computed in parallel with the servo. Still, the document matches the model,
// stroke by stroke, and its replay leaves the same bytes. Includes cuts, undo, and strokes that are
// interrupted.
TEST(DocumentWriter, KeepsWhatABrushDoes) {
  for (const ForceModel model : {ForceModel::series, ForceModel::energy})
    for (const bool threads : {false, true}) {
      Folder folder;
      const std::filesystem::path file = folder.path / "live.kibori";
      VirtualDeviceSettings device;
      device.capabilities = arm();
      LiveSettings settings;
      settings.tool = BallTool{2};
      settings.model = model;
      settings.log = true;
      settings.symmetry.planes = {true, false, false};
      settings.symmetry.centre_mm = Vec3(20, 15, 10);
      settings.spring.stiffness_n_mm = 1;
      // The hand moves over the edges of the block's top, and away from it.
      const auto script = [](double t) {
        return VirtualDevice::Target{
            Vec3(18 * std::sin(5 * t), 14 * std::cos(3 * t), -5 + std::cos(7 * t)),
            Mat3::Identity(), 0};
      };
      Rig r = rig(device, settings, script);
      LiveCarving& live = *r.live;
      auto document = Document::create(file, live.context().model(), "{}");
      ASSERT_TRUE(document.ok()) << document.error();
      const Mode modes[] = {Mode::smooth, Mode::cut,     Mode::inflate, Mode::off,
                            Mode::rasp,   Mode::flatten, Mode::fill,    Mode::deposit};
      double largest = 0;
      {
        DocumentWriter writer(live, std::move(document).value());
        const auto change = [&](int i) {
          return [&modes, i](ServoContext& c) {
            c.settings().mode = modes[static_cast<size_t>(i) % std::size(modes)];
            c.settings().brush = {2.0 + i % 3, 0.8, Falloff::smooth, 0.5};
          };
        };
        if (threads) {
          writer.start();
          live.start();
        } else {
          live.context().safety().arm();
        }
        for (int i = 0; i < 16; i++) {
          ASSERT_TRUE(live.post(change(i)));
          if (threads) {
            std::this_thread::sleep_for(std::chrono::milliseconds(120));
          } else {
            for (int k = 0; k < 250; k++) {
              const LiveTick tick = live.tick(0.001);
              const double n = tick.computed.force.norm();
              if (reshapes(modes[static_cast<size_t>(i) % std::size(modes)])) {
                largest = std::max(largest, n);
                EXPECT_LT(n, 500) << i;
              }
              if (k % 20 == 0) writer.write();
              if (k % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
          }
          if (i % 5 == 4) live.cancel_stroke();
          if (i % 4 == 2) {
            writer.undo();
            for (int k = 0; k < 20000 && !writer.idle(); k++) {
              if (threads) {
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
              } else {
                live.tick(0.001);
                writer.write();
                std::this_thread::sleep_for(std::chrono::microseconds(100));
              }
            }
            EXPECT_TRUE(writer.idle());
          }
        }
        if (threads) {
          live.stop();
          writer.stop();
        } else {
          live.context().finish_stroke();
          writer.write();
          EXPECT_GT(largest, 0.01);  // the amount depends on when the dabs are done
        }
        EXPECT_EQ(writer.write_error(), "");
        EXPECT_EQ(writer.document().steps().at(writer.document().head()).hash,
                  live.context().model().content_hash());
      }
      auto after = Document::open(file, Document::Access::read);
      ASSERT_TRUE(after.ok()) << after.error();
      size_t brushed = 0;
      for (const auto& [id, step] : after.value()->steps())
        if (!step.stock) brushed += reshapes(after.value()->settings(id).value().mode);
      EXPECT_GE(brushed, threads ? 1u : 4u);
      expect_sound(*after.value());
    }
}

// A hand that is faster than its dabs. The dabs are done later, and the stroke ends where the hand
// ended.
TEST(DocumentWriter, AFastBrushKeepsItsEnd) {
  Folder folder;
  const std::filesystem::path file = folder.path / "fast.kibori";
  VirtualDeviceSettings device;
  device.capabilities = arm();
  device.capabilities.speed_mm_s = 1e6;
  LiveSettings settings;
  settings.mode = Mode::smooth;
  settings.brush.radius_mm = 8;
  settings.log = true;
  Rig r = rig(device, settings, [](double t) {
    return VirtualDevice::Target{Vec3(std::min(18.0, -18 + 180 * t), 15, -5), Mat3::Identity(), 0};
  });
  LiveCarving& live = *r.live;
  auto document = Document::create(file, live.context().model(), "{}");
  ASSERT_TRUE(document.ok()) << document.error();
  DocumentWriter writer(live, std::move(document).value());
  Vec3 end = Vec3::Zero();
  for (int k = 0; k < 190; k++) end = live.tick(0.001).tool.tip;
  bool lifted = false;
  ASSERT_TRUE(live.post([&](ServoContext& c) {
    c.settings().mode = Mode::off;
    lifted = true;
  }));
  for (int k = 0; k < 20000 && !lifted; k++) {
    live.tick(0.001);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(lifted);
  writer.write();
  const Document& after = writer.document();
  ASSERT_EQ(after.steps().size(), 2u);
  Vec3 last = Vec3::Zero();
  ASSERT_TRUE(after
                  .for_ticks(after.head(),
                             [&](const std::vector<RecordedTick>& ticks) -> Status {
                               last = test::tip_of(ticks.back());
                               return Ok{};
                             })
                  .ok());
  EXPECT_EQ(last, end);
  EXPECT_EQ(after.steps().at(after.head()).hash, live.context().model().content_hash());
  expect_sound(after);
}

// Goes back and forth in the history while the hand continues, also during strokes. The model is
// always that of the document's current step, and everything can be replayed.
TEST(DocumentWriter, UndoAndRedoWhileAHandCarves) {
  Random random;
  Folder folder;
  for (const ForceModel model : {ForceModel::series, ForceModel::paper}) {
    const std::filesystem::path file =
        folder.path / (model == ForceModel::series ? "s.kibori" : "p.kibori");
    Rig r = busy_rig(model);
    LiveCarving& live = *r.live;
    auto document = Document::create(file, live.context().model(), "{}");
    ASSERT_TRUE(document.ok()) << document.error();
    const int rounds = std::getenv("KIBORI_SHORT") ? 30 : 150;
    int undone = 0, cancelled = 0;
    size_t written = 0;
    {
      DocumentWriter writer(live, std::move(document).value(), true);
      live.context().safety().arm();
      const auto run = [&](int ticks) {
        for (int i = 0; i < ticks; i++) {
          live.tick(0.001);
          if (i % 20 == 0) writer.write();
        }
      };
      const auto set_mode = [&](Mode mode) {
        ASSERT_TRUE(live.post([mode](ServoContext& l) { l.settings().mode = mode; }));
      };
      const auto settled = [&] {
        for (int i = 0; i < 100 && !writer.idle(); i++) run(3);
        ASSERT_TRUE(writer.idle());
      };
      run(1200);
      for (int round = 0; round < rounds; round++) {
        enum Action { kRun, kUndo, kRedo, kGo, kCancel };
        const auto action = static_cast<Action>(random.integer(kRun, kCancel));
        if (action == kRun) run(random.integer(1, 900));
        // Half of the time, the request comes during a stroke, which is finished first.
        const bool lifted = random.integer(0, 1) == 0;
        if (lifted) {
          set_mode(Mode::off);
          run(50);
        }
        const StepId before = writer.document().head();
        const size_t steps = writer.document().steps().size();
        writer.notice();
        if (action == kUndo) writer.undo();
        if (action == kRedo) writer.redo();
        if (action == kGo) writer.go(random.integer(1, static_cast<int>(steps)));
        if (action == kCancel) {
          live.cancel_stroke();
          live.cancel_stroke();
          run(1);
          cancelled++;
        }
        settled();
        if (lifted) {
          EXPECT_FALSE(writer.document().in_stroke());
          EXPECT_EQ(writer.document().steps().at(writer.document().head()).hash,
                    live.context().model().content_hash())
              << random.note();
          EXPECT_EQ(writer.document().steps().size(), steps);
          if (action == kUndo) {
            const StepId parent = writer.document().steps().at(before).parent;
            EXPECT_EQ(writer.document().head(), parent == 0 ? before : parent);
            EXPECT_EQ(writer.notice().empty(), parent != 0);
            undone += parent != 0;
          }
          set_mode(Mode::cut);
        }
        run(random.integer(1, 300));
      }
      writer.go(4711);
      settled();
      EXPECT_NE(writer.notice().find("has no step 4711"), std::string::npos);
      live.context().finish_stroke();
      writer.write();
      EXPECT_EQ(writer.write_error(), "");
      EXPECT_EQ(writer.document().steps().at(writer.document().head()).hash,
                live.context().model().content_hash());
      written = writer.document().steps().size();
    }
    // With 100 rounds or more, each kind of action must have occurred.
    EXPECT_TRUE(rounds < 100 || (undone > 0 && cancelled > 0 && written > 10));
    auto after = Document::open(file, Document::Access::read);
    ASSERT_TRUE(after.ok()) << after.error();
    // Every step is finished, and its ticks and forces are those of the hand.
    for (const auto& [id, step] : after.value()->steps()) EXPECT_TRUE(step.finished);
    expect_sound(*after.value());
    EXPECT_EQ(after.value()->load().value()->content_hash(), live.context().model().content_hash());
  }
}

// A cancelled stroke is gone, even if another request comes at the same moment.
TEST(DocumentWriter, CancelledBeforeAnythingElse) {
  Folder folder;
  Rig r = busy_rig(ForceModel::series);
  LiveCarving& live = *r.live;
  auto document = Document::create(folder.path / "c.kibori", live.context().model(), "{}");
  ASSERT_TRUE(document.ok()) << document.error();
  DocumentWriter writer(live, std::move(document).value());
  live.context().safety().arm();
  for (int i = 0; i < 5000 && !writer.document().in_stroke(); i++) {
    live.tick(0.001);
    writer.write();
  }
  ASSERT_TRUE(writer.document().in_stroke());
  live.cancel_stroke();
  ASSERT_TRUE(live.post([](ServoContext& l) { l.settings().mode = Mode::off; }));
  live.tick(0.001);
  writer.write();
  EXPECT_FALSE(writer.document().in_stroke());
  EXPECT_EQ(writer.document().steps().size(), 1u);
  EXPECT_EQ(live.context().model().content_hash(), writer.document().steps().at(1).hash);
}

// Undo, redo and versions on a third thread, in addition to the servo's and the writer's. In the
// second round the document was just opened, so its states are made in parallel with the hand.
TEST(DocumentWriter, HistoryFromAnotherThread) {
  Random random;
  Folder folder;
  const std::filesystem::path file = folder.path / "t.kibori";
  size_t versions = 0;
  for (const bool again : {false, true}) {
    Result<std::unique_ptr<Document>> document = Error{"none"};
    Result<std::unique_ptr<TriDexel>> model = Error{"none"};
    if (again) {
      document = Document::open(file, Document::Access::write);
      ASSERT_TRUE(document.ok()) << document.error();
      versions = document.value()->versions().size();
      model = document.value()->load();
      ASSERT_TRUE(model.ok()) << model.error();
    }
    Rig r = busy_rig(ForceModel::series, again ? std::move(model).value() : nullptr);
    LiveCarving& live = *r.live;
    if (!again) document = Document::create(file, live.context().model(), "{}");
    ASSERT_TRUE(document.ok()) << document.error();
    DocumentWriter writer(live, std::move(document).value());
    writer.start();
    live.start();
    std::atomic<int> calls{0};
    for (int i = 0; i < 40; i++) {
      switch (random.integer(0, 4)) {
        case 0:
          writer.undo();
          break;
        case 1:
          writer.redo();
          break;
        case 2:
          writer.go(random.integer(1, 5));
          break;
        case 3:
          live.cancel_stroke();
          break;
        default:
          writer.with([&](Document& d) {
            const std::string name = (again ? "w" : "v") + std::to_string(calls);
            if (d.name_version(name, d.head()).ok()) calls++;
          });
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(random.integer(0, 80)));
    }
    for (int i = 0; i < 6000 && !writer.idle(); i++)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_TRUE(writer.idle());
    live.stop();
    writer.stop();
    EXPECT_EQ(writer.write_error(), "");
    EXPECT_EQ(writer.document().versions().size(), versions + static_cast<size_t>(calls));
    EXPECT_EQ(writer.document().steps().at(writer.document().head()).hash,
              live.context().model().content_hash());
  }
  auto after = Document::open(file, Document::Access::read);
  ASSERT_TRUE(after.ok()) << after.error();
  expect_sound(*after.value());
}

// Position of the hand at each tick, and its time. The checker reads them after the process is
// killed.
struct Witness {
  std::atomic<int64_t> ticks;
  double x_mm[20000];
  int64_t at_us[20000];
};

int64_t now_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

class WatchedDevice final : public Device {
 public:
  WatchedDevice(std::unique_ptr<Device> device, Witness& witness)
      : device_(std::move(device)), witness_(witness) {}
  const DeviceCapabilities& capabilities() const override { return device_->capabilities(); }
  DeviceStatus read(DeviceReading& reading) override {
    const DeviceStatus status = device_->read(reading);
    const auto i = static_cast<size_t>(witness_.ticks.load());
    witness_.x_mm[i] = reading.position_mm.x();
    witness_.at_us[i] = now_us();
    witness_.ticks++;
    return status;
  }
  DeviceStatus write(const Wrench& wrench) override { return device_->write(wrench); }
  std::string complaint() const override { return device_->complaint(); }

 private:
  std::unique_ptr<Device> device_;
  Witness& witness_;
};

// kill -9 while a hand carves in real time. The file opens with an exact prefix of the work. Prints
// the time that is missing at the end.
TEST(DocumentWriter, KilledWhileAHandCarves) {
  Random random;
  Folder folder;
  const std::filesystem::path file = folder.path / "k.kibori";
  auto* const witness = static_cast<Witness*>(
      mmap(nullptr, sizeof(Witness), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(witness, MAP_FAILED);
  const char* const value = std::getenv("KIBORI_KILLS");
  const int kills = value ? std::atoi(value) : 5;
  std::vector<double> lost_ms;
  for (int round = 0; round < kills; round++) {
    for (const char* rest : {"", "-wal", "-shm"}) std::filesystem::remove(file.string() + rest);
    new (witness) Witness{};
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      VirtualDeviceSettings device;
      device.capabilities = arm();
      LiveSettings settings;
      settings.tool = BallTool{3};
      settings.log = true;
      settings.spring.stiffness_n_mm = 1;
      settings.materials[0].u = 0.02;
      settings.workspace = Workspace(Vec3(20, 15, 25));
      // The tool moves along the block and is always in the wood.
      auto hand = std::make_unique<VirtualDevice>(device, [](double t) {
        return VirtualDevice::Target{Vec3(-25 + 8 * t, 0, -6.5 + std::cos(7 * t)), Mat3::Identity(),
                                     0};
      });
      auto live = LiveCarving::make(
          test::block(0.25), std::make_unique<WatchedDevice>(std::move(hand), *witness), settings);
      auto document = Document::create(file, live.value()->context().model(), "{}");
      if (!document) _exit(1);
      DocumentWriter writer(*live.value(), std::move(document).value());
      writer.start();
      live.value()->start();
      // A request from another thread ends a stroke, and the next begins.
      for (int i = 0; i < 40; i++) {
        std::this_thread::sleep_for(std::chrono::milliseconds(150));
        live.value()->post([](ServoContext&) {});
      }
      _exit(0);
    }
    for (int i = 0; i < 60000 && witness->ticks == 0; i++)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_GT(witness->ticks.load(), 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(random.integer(700, 2500)));
    const int64_t end_us = now_us();
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    auto document = Document::open(file, Document::Access::write);
    ASSERT_TRUE(document.ok()) << document.error() << random.note();
    expect_sound(*document.value());
    // The last stored tick, and the first missing one.
    const Step& last = document.value()->steps().rbegin()->second;
    if (last.stock) continue;
    RecordedTick tick;
    ASSERT_TRUE(document.value()
                    ->for_ticks(last.id,
                                [&](const std::vector<RecordedTick>& ticks) -> Status {
                                  tick = ticks.back();
                                  return Ok{};
                                })
                    .ok());
    const auto& move = std::get<MoveTick>(tick.what);
    const double x = move.tip.x() + move.stretch_mm.x() - 20;
    auto i = static_cast<size_t>(witness->ticks.load());
    while (i > 0 && std::abs(witness->x_mm[i - 1] - x) > 1e-9) i--;
    ASSERT_GT(i, 0u) << "a tick that was never made" << random.note();
    if (static_cast<int64_t>(i) == witness->ticks.load()) continue;
    lost_ms.push_back(static_cast<double>(end_us - witness->at_us[i]) / 1000);
  }
  munmap(witness, sizeof(Witness));
  std::sort(lost_ms.begin(), lost_ms.end());
  if (!lost_ms.empty())
    std::printf("%zu kills while carving: lost %.0f ms (median), at most %.0f ms\n", lost_ms.size(),
                lost_ms[lost_ms.size() / 2], lost_ms.back());
}

// The model's hash after each stroke, and the positions of the tip. The checker reads them after
// the process is killed during dabs and warps.
struct Strokes {
  std::atomic<int64_t> ticks, ends, commits;
  uint64_t hashes[1000];
  Vec3 tips_mm[20000];
};

// kill -9 during strokes of dabs, warps and clay. The file opens, and `verify` replays it to the
// same bytes. It is an exact prefix of what was done. The hashes after each stroke match those of
// the process, in order. Each tick's tip is one of the hand's, in order.
TEST(DocumentWriter, KilledAmidDabsAndWarps) {
  Random random;
  Folder folder;
  const std::filesystem::path file = folder.path / "k.kibori";
  auto* const witness = static_cast<Strokes*>(
      mmap(nullptr, sizeof(Strokes), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(witness, MAP_FAILED);
  const int kills = test::rounds_of("KIBORI_DAB_KILLS", 10);
  size_t strokes = 0, amid = 0;
  std::set<Mode> modes_met;
  for (int round = 0; round < kills; round++) {
    for (const char* rest : {"", "-wal", "-shm"}) std::filesystem::remove(file.string() + rest);
    new (witness) Strokes{};
    const int first = random.integer(0, 100);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      VirtualDeviceSettings device;
      device.capabilities = arm();
      device.capabilities.dof_out = 0;
      device.count_mm = 0;
      LiveSettings settings;
      settings.mode = Mode::off;
      settings.tool = BallTool{2};
      settings.model = ForceModel::energy;  // its tool is where the hand is
      settings.brush = {2.5, 0.8, Falloff::smooth, 0};
      settings.materials[0].plastic = true;
      settings.log = true;
      Rig r = rig(device, settings, [](double t) {
        return VirtualDevice::Target{
            Vec3(15 * std::sin(5 * t), 11 * std::cos(3 * t), -5.5 + std::cos(7 * t)),
            rotation(Vec3(0, 0, std::sin(3 * t))), 0};
      });
      LiveCarving& live = *r.live;
      auto document = Document::create(file, live.context().model(), "{}");
      if (!document) _exit(1);
      DocumentWriter writer(live, std::move(document).value());
      writer.start();
      live.context().safety().arm();
      for (int i = first; i < first + 1000; i++) {
        const std::vector<Mode>& modes = test::reshaping_modes();
        const Mode mode = modes[static_cast<size_t>(i) % modes.size()];
        bool over = false;
        live.post([&over, mode, witness](ServoContext& c) {
          // After the previous stroke, when all of it is in the model.
          witness->hashes[witness->ends++] = c.model().content_hash();
          c.settings().mode = mode;
          over = true;
        });
        for (int k = 0; k < 150 || !over; k++) {
          const LiveTick tick = live.tick(0.001);
          witness->tips_mm[witness->ticks++] = tick.tool.tip;
          witness->commits += tick.cutting;
          if (witness->ticks == 20000) _exit(0);
          std::this_thread::sleep_for(std::chrono::microseconds(300));
        }
      }
      _exit(0);
    }
    for (int i = 0; i < 60000 && witness->commits == 0; i++)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_GT(witness->commits.load(), 0);
    std::this_thread::sleep_for(std::chrono::microseconds(random.integer(0, 900'000)));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    SCOPED_TRACE(testing::Message() << "kill " << round << ": " << random.note());
    auto document = Document::open(file, Document::Access::write);
    ASSERT_TRUE(document.ok()) << document.error();
    expect_sound(*document.value());
    auto model = document.value()->load();
    ASSERT_TRUE(model.ok()) << model.error();
    EXPECT_EQ(model.value()->content_hash(), document.value()->steps().rbegin()->second.hash);
    // A mode that changed nothing made no stroke, and a stroke may end where it began.
    std::vector<uint64_t> had(witness->hashes, witness->hashes + witness->ends), there;
    for (const auto& [id, step] : document.value()->steps()) there.push_back(step.hash);
    for (std::vector<uint64_t>* hashes : {&had, &there})
      hashes->erase(std::unique(hashes->begin(), hashes->end()), hashes->end());
    // The kill, or a partial write, may have cut off the last stroke.
    if (there.size() > had.size() || there.back() != had[there.size() - 1]) {
      there.pop_back();
      amid++;
    }
    ASSERT_LE(there.size(), had.size());
    EXPECT_TRUE(std::equal(there.begin(), there.end(), had.begin()));
    size_t at = 0;
    const auto ticks = static_cast<size_t>(witness->ticks.load());
    for (const auto& [id, step] : document.value()->steps()) {
      if (step.stock) continue;
      strokes++;
      modes_met.insert(document.value()->settings(id).value().mode);
      const Status read =
          document.value()->for_ticks(id, [&](const std::vector<RecordedTick>& all) -> Status {
            for (const RecordedTick& tick : all) {
              while (at < ticks && witness->tips_mm[at] != test::tip_of(tick)) at++;
              EXPECT_LT(at, ticks) << "a tick that was never made";
            }
            return Ok{};
          });
      ASSERT_TRUE(read.ok()) << read.error();
    }
  }
  munmap(witness, sizeof(Strokes));
  std::printf("%d kills: %zu strokes in %zu modes, %zu cut off by the kill\n", kills, strokes,
              modes_met.size(), amid);
  EXPECT_GT(strokes, static_cast<size_t>(kills));
  if (kills >= 10) {
    EXPECT_GT(amid, 0u);
  }
}

// The disk becomes full while a hand carves. This is reported. The hand continues, and undo and
// redo still work. Everything can be saved elsewhere.
TEST(DocumentWriter, AFullDiskIsReportedAndNothingIsLost) {
  FaultVfs& vfs = FaultVfs::get();
  vfs.reset();
  Folder folder;
  const std::filesystem::path file = folder.path / "full.kibori",
                              other = folder.path / "other.kibori";
  Rig r = busy_rig(ForceModel::series);
  LiveCarving& live = *r.live;
  auto document = Document::create(file, live.context().model(), "{}", {}, FaultVfs::kName);
  ASSERT_TRUE(document.ok()) << document.error();
  {
    DocumentWriter writer(live, std::move(document).value());
    live.context().safety().arm();
    const auto run = [&](int ticks) {
      for (int i = 0; i < ticks; i++) {
        live.tick(0.001);
        if (i % 20 == 0) writer.write();
      }
    };
    run(1500);
    EXPECT_EQ(writer.write_error(), "");
    vfs.error = SQLITE_FULL;
    vfs.fail_on = true;
    vfs.fail_at = vfs.count + 1;
    run(1500);
    EXPECT_NE(writer.write_error().find("full.kibori"), std::string::npos) << writer.write_error();
    writer.undo();
    run(1500);
    EXPECT_TRUE(writer.idle());
    Status moved = Error{"not asked"};
    writer.with([&](Document& d) { moved = d.move_to(other); });
    run(500);
    EXPECT_TRUE(moved.ok()) << moved.error();
    EXPECT_EQ(writer.write_error(), "");
    live.context().finish_stroke();
    writer.write();
  }
  vfs.reset();
  for (const auto& path : {file, other}) {
    auto after = Document::open(path, Document::Access::write);
    ASSERT_TRUE(after.ok()) << after.error();
    expect_sound(*after.value());
    if (path == other) {
      EXPECT_EQ(after.value()->load().value()->content_hash(),
                live.context().model().content_hash());
    }
  }
}

}  // namespace
}  // namespace kibori::document_writer_tests
