// SPDX-License-Identifier: MIT
// Carving by hand: device, tool, model and safety stage in one tick, and the thread that runs it.
//
//   servo thread:   read ─► workspace ─► spring tool (cut) ─► passivity ─► safety ─► write
//                                              │
//   other threads:  post(command) ─► between ticks ─► snapshot ─► latest()
//
// The servo thread owns the model and all else that a ServoContext holds. A tick neither allocates,
// locks, faults nor throws; commands are run between ticks and freed elsewhere.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include <kibori/base/handover.h>
#include <kibori/base/result.h>
#include <kibori/haptics/servo.h>
#include <kibori/live/servo_context.h>

namespace kibori {

class LiveCarving {
 public:
  // `second`: of a second hand, as LiveSettings::second says; null: there is none. Errors: a rate,
  // tool or stiffness that can't be, or a rendering beyond the device's damping.
  static Result<std::unique_ptr<LiveCarving>> make(std::unique_ptr<TriDexel> model,
                                                   std::unique_ptr<Device> device,
                                                   const LiveSettings& settings,
                                                   std::unique_ptr<Device> second = nullptr);
  ~LiveCarving();

  // Starts the servo thread, which owns the model until stop(), and arms the safety stage if
  // LiveSettings::armed. In between others may call only post(), latest(), next_tick() and
  // cancel_stroke(), and one thread reads log().
  void start();
  void stop();
  // One tick, `elapsed_s` after the last, by the caller instead of a servo thread; it waits until
  // what a stroke severed is known, so that ticks come to the same however fast they are asked for.
  // Its own mistake to call it while a thread runs: the program stops.
  LiveTick tick(double elapsed_s);
  // The same as the servo thread does it, which waits for nothing: for a caller's own loop in real
  // time.
  LiveTick tick_at_once(double elapsed_s);

  // Runs `command` between two ticks, on the servo thread; false where 64 are waiting. Any thread.
  // Dabs that are under way come first, and the stroke that is being made ends.
  bool post(std::function<void(ServoContext&)> command) { return post(std::move(command), true); }
  // The same, and the stroke goes on: for what the second hand does in it, as it is put down or
  // lifted.
  bool post_within_stroke(std::function<void(ServoContext&)> command) {
    return post(std::move(command), false);
  }
  // The newest snapshot, if there is one that was not taken yet. Always the same thread.
  bool latest(Snapshot& snapshot) {
    BodyId body = 0;
    return latest(snapshot, body);
  }
  // And of which body it is.
  bool latest(Snapshot& snapshot, BodyId& body) {
    Seen seen;
    if (!snapshots_.take(seen)) return false;
    snapshot = std::move(seen.model);
    body = seen.body;
    return true;
  }

  // Every tick in order, where LiveSettings::watched; those of whoever falls behind by two seconds
  // are left out. Always the same thread.
  bool next_tick(LiveTick& tick) { return context_.watched_ && context_.watched_->pop(tick); }

  // What the servo thread owns, while it does not run: before start() and after stop(). While it
  // runs, commands get it, and asking here stops the program.
  ServoContext& context();

  // Discards the stroke that is being made, at the next tick, if strokes are logged. Any thread.
  void cancel_stroke() { cancel_.store(true, std::memory_order_relaxed); }

  // Strokes as they are made: one begins when the tool first cuts or fills, and ends when it has
  // not for LiveSettings::idle_s, jumps, or a command comes. One thread reads it: the
  // DocumentWriter's.
  StrokeLog& log() { return context_.log_; }

  // Of the run that is over: they may be asked for when context() may.
  const ServoStatistics& statistics() const;
  const std::string& scheduling() const;
  const LiveTotals& totals() const;

 private:
  struct Command {
    std::function<void(ServoContext&)> run;
    bool ends_stroke = true;
  };
  LiveCarving(std::unique_ptr<TriDexel> model, std::unique_ptr<Device> device,
              const LiveSettings& settings, std::unique_ptr<Device> second)
      : context_(std::move(model), std::move(device), settings, std::move(second)) {}
  bool post(std::function<void(ServoContext&)> command, bool ends_stroke);
  void check_stopped() const;
  LiveTick run_tick(double elapsed_s);
  void run_command();

  ServoContext context_;  // of the servo thread while it runs
  uint64_t ticks_ = 0, published_ = 0;
  std::atomic<bool> cancel_{false};
  struct Seen {
    Snapshot model;
    BodyId body = 1;
  };
  LatestValue<Seen> snapshots_;
  std::mutex posting_;  // between those who post
  SmallQueue<Command*> commands_;
  SmallQueue<Command*, 128> finished_;

  std::thread thread_;
  std::atomic<bool> stopping_{false};
  ServoStatistics statistics_;
  std::string scheduling_;
};

}  // namespace kibori
