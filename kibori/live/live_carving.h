// SPDX-License-Identifier: MIT
// Carving by hand: device, tool, model and safety stage in one tick, and the thread that runs it.
//
//   servo thread:   device.read ─► workspace ─► series tool (cut) ─► passivity ─► safety ─► device.write
//                                                     │
//   other threads:  post(command) ─► between ticks    └─► snapshot ─► latest()
//
// The servo thread owns the model. A tick neither allocates, locks, faults nor throws; commands are run
// between ticks and freed elsewhere.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <kibori/base/handover.h>
#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/haptics/device.h>
#include <kibori/haptics/passivity.h>
#include <kibori/haptics/safety.h>
#include <kibori/haptics/servo.h>
#include <kibori/haptics/workspace.h>
#include <kibori/live/stroke_log.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/spring_tool.h>

namespace kibori {

struct LiveSettings {
  double rate_hz = 1000;  // 100 ... 4000
  Tool tool = BallTool{};
  Mode mode = Mode::cut;
  uint8_t material = 0;  // of a deposit
  std::vector<Material> materials{Material{}};
  Symmetry symmetry;
  ForceModel model = ForceModel::series;
  SeriesSpring spring;         // its tick_s is set from rate_hz
  double force_scale = 1;      // of what the device gives, to what is computed
  double passivity_ns_mm = 0;  // the passivity controller's cap; 0: it only watches
  Workspace workspace;
  int snapshot_ticks = 16;  // between snapshots
  bool log = false;         // strokes go into log(), for a DocumentWriter
  double idle_s = 0.3;      // a stroke ends when the tool has not cut or filled for so long
  bool watched = false;     // ticks can be read by next_tick()
  bool armed = true;        // start() arms the safety stage; else safety().arm() does, by a command
};

// What one tick came to.
struct LiveTick {
  Pose tool;
  Wrench computed, given;  // before and after the safety stage
  double removed_mm3 = 0;
  bool touching = false, cutting = false, inside = false;
  SafetyStage::State safety = SafetyStage::State::off;
  Trip trip = Trip::none;  // why it is off
};

// Over all ticks.
struct LiveTotals {
  double removed_mm3 = 0, deposited_mm3 = 0;
  double max_computed_n = 0, max_given_n = 0;
  uint64_t cutting_ticks = 0;
  uint64_t jumps = 0;      // ticks in which the device moved farther than a hand can; the tool was put there
  Trip trip = Trip::none;  // the first
};

class LiveCarving {
 public:
  // Errors: a rate, tool or stiffness that can't be, or a rendering beyond the device's damping.
  static Result<std::unique_ptr<LiveCarving>> make(std::unique_ptr<TriDexel> model,
                                                   std::unique_ptr<Device> device,
                                                   const LiveSettings& settings);
  ~LiveCarving();

  // Starts the servo thread, which owns the model until stop(), and arms the safety stage if
  // LiveSettings::armed. In between others may call only post(), latest(), next_tick() and cancel_stroke(),
  // and one thread reads log().
  void start();
  void stop();
  // Without a thread: one tick, `elapsed_s` after the last.
  LiveTick tick(double elapsed_s);

  // Runs `command` between two ticks, on the servo thread; false where 64 are waiting. Any thread.
  bool post(std::function<void(LiveCarving&)> command);
  // The newest snapshot, if there is one that was not taken yet. Always the same thread.
  bool latest(Snapshot& snapshot) { return snapshots_.take(snapshot); }

  // Every tick in order, where LiveSettings::watched; those of whoever falls behind by two seconds are left
  // out. Always the same thread.
  bool next_tick(LiveTick& tick) { return watched_ && watched_->pop(tick); }

  // Tiles per field that may be edited between two refills without asking the system for memory. Callers that
  // keep snapshots must refill (Snapshot::keep_ready).
  static constexpr int kReadyTiles = 1024;

  // For commands, and while no thread runs.
  TriDexel& model() { return *model_; }
  Device& device() { return *device_; }
  SafetyStage& safety() { return safety_; }
  const PassivityObserver& passivity() const { return passivity_; }
  LiveSettings& settings() { return settings_; }
  // Of the series spring; where the device could not bear it, nothing changes. For commands.
  void set_stiffness(double n_mm);
  // The hand's strength [N] and stiffness, and the share of the cut's force that it bears; a device is given
  // the pull times `force_scale`. Where it could not bear that, nothing changes. For commands.
  void set_hand(double stiffness_n_mm, double strength_n, double hand_share, double force_scale);
  // From the next stroke on; check_symmetry has passed. For commands.
  void set_symmetry(const Symmetry& symmetry);
  // The next reading of the device puts the tool there at once; nothing is cut on the way. For commands.
  void place_again() { placed_ = false; }
  // The model was changed from outside. For commands.
  void model_changed() { series_.disengage(); }
  // Another tool from now on. Where it stands in material it backs out along its axis, and comes in again
  // from there; where it can't, it waits to be pulled out. For commands.
  void change_tool(const Tool& tool);
  // The tool is at `pose`, or backed out from there along its axis until it is clear of material, and works
  // from now on. Gives where it is; nothing where it can't be clear: it then waits there. For commands.
  std::optional<Pose> place_clear(const Pose& pose);
  // The same, without looking whether it is clear: where material is put down. For commands.
  void place_at(const Pose& pose);
  // A mallet's blow of so much work, in the next tick: see SpringTool::advance. For commands.
  void strike(double nmm) { strike_nmm_ = nmm; }

  // Discards the stroke that is being made, at the next tick, if strokes are logged. Any thread.
  void cancel_stroke() { cancel_.store(true, std::memory_order_relaxed); }

  // Strokes as they are made: one begins when the tool first cuts or fills, and ends when it has not for
  // LiveSettings::idle_s, jumps, or a command comes. One thread reads it: the DocumentWriter's.
  StrokeLog& log() { return log_; }
  // Ends the stroke that is being made. For commands, and while no thread runs; stop() does it.
  void finish_stroke();

  // After stop().
  const ServoStatistics& statistics() const { return statistics_; }
  const std::string& scheduling() const { return scheduling_; }
  const LiveTotals& totals() const { return totals_; }

 private:
  using Command = std::function<void(LiveCarving&)>;
  using Watched = SmallQueue<LiveTick, 8192>;
  LiveCarving(std::unique_ptr<TriDexel> model, std::unique_ptr<Device> device, const LiveSettings& settings);
  void run_command();
  void discard_stroke();
  void keep_before_stroke();
  ForceLaw law() const;
  LiveTick advance(DeviceStatus& status);
  void note(const LiveTick& tick);
  void log_tick(const Pose& before, const StrokeTick& tick, const Wrench& felt, double removed_mm3);

  std::unique_ptr<TriDexel> model_;
  std::unique_ptr<Device> device_;
  LiveSettings settings_;
  SpringTool series_;
  DirectTool stroke_;
  SafetyStage safety_;
  PassivityObserver passivity_;
  DeviceReading reading_;
  bool placed_ = false;  // the tool is where a hand was seen
  Pose wanted_;          // by the hand, in the last tick
  uint64_t ticks_ = 0, published_ = 0;
  StrokeLog log_;
  std::shared_ptr<const std::vector<Material>> logged_materials_;
  bool in_stroke_ = false;
  std::unique_ptr<Watched> watched_;    // null: no one does
  Snapshot before_stroke_;              // what cancel_stroke() goes back to
  uint64_t before_generation_ = ~0ull;  // of it
  std::atomic<bool> cancel_{false};
  int idle_ticks_ = 0;  // since the stroke's last edit
  double stroke_removed_mm3_ = 0;
  double strike_nmm_ = 0;
  LiveTotals totals_;

  LatestValue<Snapshot> snapshots_;
  std::mutex posting_;  // between those who post
  SmallQueue<Command*> commands_;
  SmallQueue<Command*, 128> finished_;

  std::thread thread_;
  std::atomic<bool> stopping_{false};
  ServoStatistics statistics_;
  std::string scheduling_;
};

}  // namespace kibori
