// SPDX-License-Identifier: MIT
// A scene that is carved while someone looks: its ticks and the model as they come, and all of it
// in the end.
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
  // `pace`: 1 is the scene's own time, 0 as fast as it goes. Errors: those of the stock.
  static Result<std::unique_ptr<Session>> start(const Scene& scene, double pace);
  ~ExperimentSession() override;

  ExperimentSession* experiment() override { return this; }

  const Scene& scene() const { return scene_; }
  // The tool, where it is another since the last call; one thread.
  bool next_tool(Tool& tool) { return tools_.take(tool); }
  // How much is done, 0 to 1.
  double share() const { return share_; }
  // No more ticks; what was done so far counts.
  void cancel() override { stopping_ = true; }
  bool stopped() const { return stopping_; }
  // Null while it runs; then all its ticks, or what was wrong.
  const Result<Carving>* outcome() const { return done_ ? &outcome_ : nullptr; }

  // It has no document.
  void thumbnail(StepId step, std::function<void(Bytes)> use) override;
  void save_copy(const std::filesystem::path& path, std::function<void(Status)> done) override;

 private:
  explicit ExperimentSession(Scene scene) : scene_(std::move(scene)) {}
  // As of LiveCarving. Whoever falls behind is left out.
  bool latest(Shown& shown) override { return states_.take(shown); }
  const Tool* second_tool() const override { return second_tool_; }
  bool next_tick(LiveTick& tick) override { return ticks_.pop(tick); }
  void update_history() override {}
  bool busy() const override { return cutting_ && !done_; }

  Scene scene_;
  LatestValue<Shown> states_;
  std::atomic<const Tool*> second_tool_{nullptr};  // of scene_
  SmallQueue<LiveTick, 8192> ticks_;
  LatestValue<Tool> tools_;
  std::atomic<double> share_{0};
  std::atomic<bool> stopping_{false}, done_{false};
  Result<Carving> outcome_ = Error{""};
  std::thread thread_;
};

}  // namespace kibori
