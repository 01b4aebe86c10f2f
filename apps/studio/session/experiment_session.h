// SPDX-License-Identifier: MIT
// An experiment: a scene that is carved while pages watch. The session gives ticks and models
// during the run, and the whole result at the end.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include <kibori/base/handover.h>
#include <kibori/run/carving.h>
#include "apps/studio/session/session.h"

namespace kibori {

class ExperimentSession final : public Session {
 public:
  // Starts the run. `pace`: 1 for the scene's own speed, 0 for the highest speed. Errors: those of
  // the stock.
  static Result<std::unique_ptr<Session>> start(const Scene& scene, double pace);
  ~ExperimentSession() override;

  ExperimentSession* experiment() override { return this; }

  const Scene& scene() const { return scene_; }
  // Writes the current tool to `tool` and returns true, if it has changed since the last call. Call
  // it on one thread.
  bool next_tool(Tool& tool) { return tools_.take(tool); }
  // Returns the progress from 0 to 1.
  double share() const { return share_; }
  // Stops the run. The ticks up to now are kept.
  void cancel() override { stopping_ = true; }
  bool stopped() const { return stopping_; }
  // Returns null during the run. After it, returns all ticks, or the error.
  const Result<Carving>* outcome() const { return done_ ? &outcome_ : nullptr; }

  // An experiment has no document, so it has no thumbnails and cannot be saved as a copy.
  void thumbnail(StepId step, std::function<void(Bytes)> use) override;
  void save_copy(const std::filesystem::path& path, std::function<void(Status)> done) override;

 private:
  explicit ExperimentSession(Scene scene) : scene_(std::move(scene)) {}
  // As in LiveCarving. A slow caller misses states and ticks.
  bool latest(Shown& shown) override { return states_.take(shown); }
  const Tool* second_tool() const override { return second_tool_; }
  bool next_tick(LiveTick& tick) override { return ticks_.pop(tick); }
  void update_history() override {}
  bool busy() const override { return cutting_ && !done_; }

  Scene scene_;
  LatestValue<Shown> states_;
  std::atomic<const Tool*> second_tool_{nullptr};  // points into scene_
  SmallQueue<LiveTick, 8192> ticks_;
  LatestValue<Tool> tools_;
  std::atomic<double> share_{0};
  std::atomic<bool> stopping_{false}, done_{false};
  Result<Carving> outcome_ = Error{""};
  std::thread thread_;
};

}  // namespace kibori
