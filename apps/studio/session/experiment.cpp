// SPDX-License-Identifier: MIT
#include "apps/studio/session/experiment.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace kibori {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kSnapshotEvery = std::chrono::milliseconds(8);

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

}  // namespace

Result<std::unique_ptr<Experiment>> Experiment::start(const Scene& scene, double pace) {
  auto model = make_stock(scene.stock, scene.file, {});
  if (!model) return Error{model.error()};
  std::unique_ptr<Experiment> experiment(new Experiment(scene));
  experiment->stock_ = model.value()->snapshot();
  experiment->thread_ =
      std::thread([self = experiment.get(), pace, stock = std::move(model).value()]() mutable {
        const auto began = Clock::now();
        auto shown = began;
        int64_t count = 0;
        CarveOptions options;
        options.progress = [self](double share) { self->share_ = share; };
        const Tool* in_hand = nullptr;
        options.each = [&](const TriDexel& model_now, const Tool& tool_now, const Pose& pose,
                           const ToolTick& result) {
          if (std::exchange(in_hand, &tool_now) != &tool_now) self->tools_.put(tool_now);
          LiveTick tick;
          tick.tool = pose;
          tick.computed = result.wrench;
          tick.removed_mm3 = result.removed_mm3;
          self->ticks_.push(tick);
          count++;
          const auto now = Clock::now();
          if (now - shown >= kSnapshotEvery) {
            shown = now;
            self->snapshots_.put(model_now.snapshot());
          }
          if (pace > 0) {
            const double due_s = static_cast<double>(count) / (pace * self->scene_.rate_hz);
            // Little by little, so that it can be stopped.
            for (double left_s; !self->stopping_ && (left_s = due_s - seconds_since(began)) > 0;)
              std::this_thread::sleep_for(std::chrono::duration<double>(std::min(left_s, 0.02)));
          }
          return !self->stopping_;
        };
        self->outcome_ = carve(self->scene_, std::move(stock), options);
        if (self->outcome_) self->snapshots_.put(self->outcome_.value().model->snapshot());
        self->share_ = 1;
        self->done_ = true;
      });
  return experiment;
}

Experiment::~Experiment() {
  stop();
  if (thread_.joinable()) thread_.join();
}

}  // namespace kibori
