// SPDX-License-Identifier: MIT
// Carving by hand. One tick runs device, tool, model and safety stage. This class also owns the
// thread that runs the ticks.
//
//   servo thread:   read ─► workspace ─► spring tool (cut) ─► passivity ─► safety ─► write
//                                              │
//   other threads:  post(command) ─► between ticks ─► snapshot ─► latest()
//
// The servo thread owns the model and everything in ServoContext. A tick does not allocate, lock,
// throw or cause page faults. Commands run between ticks and are freed on another thread.
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
  // `second` is the device of a second hand (LiveSettings::second); null if there is none. Errors:
  // an invalid rate, tool or stiffness, or a rendering that exceeds the device's damping.
  static Result<std::unique_ptr<LiveCarving>> make(std::unique_ptr<TriDexel> model,
                                                   std::unique_ptr<Device> device,
                                                   const LiveSettings& settings,
                                                   std::unique_ptr<Device> second = nullptr);
  ~LiveCarving();

  // start() starts the servo thread, which owns the model until stop(). It arms the safety stage if
  // LiveSettings::armed. While it runs, other threads may only call post(), latest(), next_tick()
  // and cancel_stroke(), and one thread reads log().
  void start();
  void stop();
  // Runs one tick, `elapsed_s` after the last, on the caller's thread. It waits for the crumb
  // worker. Therefore, the result does not depend on the speed of the calls. A call while the servo
  // thread runs is a programming error and stops the program.
  LiveTick tick(double elapsed_s);
  // The same, but like the servo thread it does not wait. For a caller with its own real-time loop.
  LiveTick tick_at_once(double elapsed_s);

  // Runs `command` between two ticks, on the servo thread. Returns false if 64 commands are
  // waiting. Pending dabs finish first, and the current stroke ends. Any thread.
  bool post(std::function<void(ServoContext&)> command) { return post(std::move(command), true); }
  // The same, but the stroke continues. For the second hand when it starts or stops in the middle
  // of a stroke.
  bool post_within_stroke(std::function<void(ServoContext&)> command) {
    return post(std::move(command), false);
  }
  // Returns true and the newest snapshot if it was not taken yet. Always call it from the same
  // thread.
  bool latest(Snapshot& snapshot) {
    BodyId body = 0;
    return latest(snapshot, body);
  }
  // Also returns the body of the snapshot.
  bool latest(Snapshot& snapshot, BodyId& body) {
    Seen seen;
    if (!snapshots_.take(seen)) return false;
    snapshot = std::move(seen.model);
    body = seen.body;
    return true;
  }

  // Returns every tick in order, if LiveSettings::watched. A reader that is more than two seconds
  // late loses ticks. Always call it from the same thread.
  bool next_tick(LiveTick& tick) { return context_.watched_ && context_.watched_->pop(tick); }

  // The data of the servo thread, before start() and after stop(). A call while the thread runs
  // stops the program; commands get the context instead.
  ServoContext& context();

  // Discards the current stroke at the next tick, if strokes are logged. `then` runs in the same
  // tick, before the hand moves on and before waiting commands. Returns false if 64 calls are
  // waiting. Any thread.
  bool cancel_stroke(std::function<void(ServoContext&)> then = {});

  // The log of strokes. A stroke begins when the tool first cuts or fills. It ends when the tool
  // has not done so for LiveSettings::idle_s, when it jumps, or when a command arrives. Only one
  // thread reads it: the DocumentWriter's.
  StrokeLog& log() { return context_.log_; }

  // Results of the last run. Call these only when context() may be called.
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
  bool put(SmallQueue<Command*>& queue, Command command);
  void check_stopped() const;
  LiveTick run_tick(double elapsed_s);
  void run_cancels();
  void run_command();

  ServoContext context_;  // the servo thread's while it runs
  uint64_t ticks_ = 0, published_ = 0;
  struct Seen {
    Snapshot model;
    BodyId body = 1;
  };
  LatestValue<Seen> snapshots_;
  std::mutex posting_;  // for callers of post() and cancel_stroke()
  SmallQueue<Command*> commands_, cancels_;
  SmallQueue<Command*, 128> finished_;

  std::thread thread_;
  std::atomic<bool> stopping_{false};
  ServoStatistics statistics_;
  std::string scheduling_;
};

}  // namespace kibori
