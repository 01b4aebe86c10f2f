// SPDX-License-Identifier: MIT
// Carving by hand. A tick (one period of the servo loop) runs device, tool, model and safety stage.
// A LiveCarving also owns the thread that runs the ticks.
//
//   servo thread:   read ─► workspace ─► spring tool (cut) ─► passivity ─► safety ─► write
//                                              │
//   other threads:  post(command) ─► between ticks ─► snapshot ─► latest()
//
// The servo thread owns the model and everything else in ServoContext. A tick does not allocate
// (except with a mesh as the tool), lock, throw or cause page faults. Commands run between ticks.
// Other threads free them.
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
  // `second` is the device of a second hand (LiveSettings::second), or null. Errors: the rate, the
  // symmetry, the brush, the materials, a tool or a spring is invalid; the second hand has a mode
  // that reshapes; the force needs more damping than a device has.
  static Result<std::unique_ptr<LiveCarving>> make(std::unique_ptr<TriDexel> model,
                                                   std::unique_ptr<Device> device,
                                                   const LiveSettings& settings,
                                                   std::unique_ptr<Device> second = nullptr);
  ~LiveCarving();

  // start() starts the servo thread, which owns the model until stop(). If LiveSettings::armed is
  // true, the thread arms the safety stages. While it runs, other threads may call only post(),
  // post_within_stroke(), latest(), next_tick() and cancel_stroke(). One thread may read log().
  void start();
  void stop();
  // Runs one tick on the caller's thread, `elapsed_s` after the last tick. Then waits for the crumb
  // worker. Therefore, the result does not depend on the speed of the calls. While the servo thread
  // runs, a call stops the program.
  LiveTick tick(double elapsed_s);
  // Like tick(), but does not wait. For callers with a real-time loop.
  LiveTick tick_at_once(double elapsed_s);

  // Runs `command` between two ticks, on the servo thread. Before that, pending dabs finish, and
  // the current stroke ends. Returns false if 64 commands are waiting. Any thread.
  bool post(std::function<void(ServoContext&)> command) { return post(std::move(command), true); }
  // Like post(), but the current stroke continues. Use it for the second hand, which may start or
  // stop in the middle of a stroke.
  bool post_within_stroke(std::function<void(ServoContext&)> command) {
    return post(std::move(command), false);
  }
  // If there is a snapshot that was not taken yet, writes it to `snapshot` and returns true. All
  // calls must come from one thread.
  bool latest(Snapshot& snapshot) {
    BodyId body = 0;
    return latest(snapshot, body);
  }
  // Like above, and writes the body of the snapshot to `body`.
  bool latest(Snapshot& snapshot, BodyId& body) {
    Seen seen;
    if (!snapshots_.take(seen)) return false;
    snapshot = std::move(seen.model);
    body = seen.body;
    return true;
  }

  // Returns the ticks in order, if LiveSettings::watched is true. Returns false if there is no new
  // tick. A reader that is more than 8192 ticks late loses ticks. All calls must come from one
  // thread.
  bool next_tick(LiveTick& tick) { return context_.watched_ && context_.watched_->pop(tick); }

  // Returns the data of the servo thread, before start() and after stop(). While the thread runs, a
  // call stops the program. Commands receive the context instead.
  ServoContext& context();

  // Discards the current stroke at the next tick, if strokes are logged. Then `then` runs in the
  // same tick, before the hand moves and before waiting commands. Returns false if 64 calls are
  // waiting. Any thread.
  bool cancel_stroke(std::function<void(ServoContext&)> then = {});

  // The log of strokes. A stroke begins with the first edit. It ends when there was no edit for
  // LiveSettings::idle_s, when the hand jumps, or when a command ends it. Only the DocumentWriter
  // reads the log.
  StrokeLog& log() { return context_.log_; }

  // Results of the last run. Call them only if context() may be called.
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

  ServoContext context_;  // belongs to the servo thread while it runs
  uint64_t ticks_ = 0, published_ = 0;
  struct Seen {
    Snapshot model;
    BodyId body = 1;
  };
  LatestValue<Seen> snapshots_;
  std::mutex posting_;  // guards the callers of post() and cancel_stroke()
  SmallQueue<Command*> commands_, cancels_;
  SmallQueue<Command*, 128> finished_;

  std::thread thread_;
  std::atomic<bool> stopping_{false};
  ServoStatistics statistics_;
  std::string scheduling_;
};

}  // namespace kibori
