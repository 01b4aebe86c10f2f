// SPDX-License-Identifier: MIT
#include "apps/studio/session/experiment_session.h"

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

Result<std::unique_ptr<Session>> ExperimentSession::start(const Scene& scene, double pace) {
  auto model = make_stock(scene.stock, scene.file, {});
  if (!model) return Error{model.error()};
  std::unique_ptr<ExperimentSession> experiment(new ExperimentSession(scene));
  experiment->name_ = scene.file;
  experiment->materials_ = scene.materials;
  experiment->stock_material_ = scene.stock.material;
  experiment->rate_hz_ = scene.rate_hz;
  experiment->begin({BodyList::of(*model.value()), 1}, 0);
  experiment->thread_ =
      std::thread([self = experiment.get(), pace, stock = std::move(model).value()]() mutable {
        const auto began = Clock::now();
        auto shown = began;
        int64_t count = 0;
        CarveOptions options;
        options.progress = [self](double share) { self->share_ = share; };
        const Tool* in_hand = nullptr;
        options.each = [&](const TriDexel& model_now, const CarvedTick& first,
                           const CarvedTick* second) {
          if (std::exchange(in_hand, &first.tool) != &first.tool) self->tools_.put(first.tool);
          const auto show = [](const CarvedTick& carved, HandTick& tick) {
            tick.tool = carved.pose;
            tick.computed = carved.result.wrench;
            tick.removed_mm3 = carved.result.removed_mm3;
            tick.points = carved.result.points;
          };
          LiveTick tick;
          show(first, tick);
          if (second) show(*second, tick.second.emplace());
          self->second_tool_ = second ? &second->tool : nullptr;
          self->ticks_.push(tick);
          count++;
          const auto now = Clock::now();
          if (now - shown >= kSnapshotEvery) {
            shown = now;
            self->states_.put({BodyList::of(model_now), 1});
          }
          if (pace > 0) {
            const double due_s = static_cast<double>(count) / (pace * self->scene_.rate_hz);
            // Sleep in short intervals, so that the run can be stopped.
            for (double left_s; !self->stopping_ && (left_s = due_s - seconds_since(began)) > 0;)
              std::this_thread::sleep_for(std::chrono::duration<double>(std::min(left_s, 0.02)));
          }
          return !self->stopping_;
        };
        self->outcome_ = carve(self->scene_, std::move(stock), options);
        if (self->outcome_) {
          const BodyList& bodies = self->outcome_.value().bodies;
          self->states_.put({bodies, bodies.all.front().id});
        }
        self->share_ = 1;
        self->done_ = true;
      });
  return std::unique_ptr<Session>(std::move(experiment));
}

ExperimentSession::~ExperimentSession() {
  cancel();
  if (thread_.joinable()) thread_.join();
}

void ExperimentSession::thumbnail(StepId, std::function<void(Bytes)> use) { use({}); }

void ExperimentSession::save_copy(const std::filesystem::path&, std::function<void(Status)> done) {
  done(Error{
      "an experiment has no document; carve the scene as an example, or with 'kibori carve'"});
}

}  // namespace kibori
