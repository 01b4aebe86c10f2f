// SPDX-License-Identifier: MIT
// A scene that is carved while someone looks: its ticks and the model as they come, and all of it in the end.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include <kibori/base/handover.h>
#include <kibori/base/result.h>
#include <kibori/batch/carving.h>
#include <kibori/live/live_carving.h>

namespace kibori {

class Experiment {
 public:
  // `pace`: 1 is the scene's own time, 0 as fast as it goes. Errors: those of the stock.
  static Result<std::unique_ptr<Experiment>> start(const Scene& scene, double pace);
  ~Experiment();

  const Scene& scene() const { return scene_; }
  // Of the stock, before the first tick.
  const Snapshot& stock() const { return stock_; }
  // As of LiveCarving; one thread. Whoever falls behind is left out.
  bool latest(Snapshot& snapshot) { return snapshots_.take(snapshot); }
  bool next_tick(LiveTick& tick) { return ticks_.pop(tick); }
  // The tool, where it is another since the last call; one thread.
  bool next_tool(Tool& tool) { return tools_.take(tool); }
  // How much is done, 0 to 1.
  double share() const { return share_; }
  // No more ticks; what was done so far counts.
  void stop() { stopping_ = true; }
  bool stopped() const { return stopping_; }
  // Null while it runs; then all its ticks, or what was wrong.
  const Result<Carving>* outcome() const { return done_ ? &outcome_ : nullptr; }

 private:
  explicit Experiment(Scene scene) : scene_(std::move(scene)) {}
  Scene scene_;
  Snapshot stock_;
  LatestValue<Snapshot> snapshots_;
  SmallQueue<LiveTick, 8192> ticks_;
  LatestValue<Tool> tools_;
  std::atomic<double> share_{0};
  std::atomic<bool> stopping_{false}, done_{false};
  Result<Carving> outcome_ = Error{""};
  std::thread thread_;
};

}  // namespace kibori
