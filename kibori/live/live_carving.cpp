// SPDX-License-Identifier: MIT
#include <kibori/live/live_carving.h>

#include <algorithm>
#include <cmath>

#include <kibori/base/check.h>

namespace kibori {

Result<std::unique_ptr<LiveCarving>> LiveCarving::make(std::unique_ptr<TriDexel> model,
                                                       std::unique_ptr<Device> device,
                                                       const LiveSettings& settings,
                                                       std::unique_ptr<Device> second) {
  if (!(settings.rate_hz >= 100 && settings.rate_hz <= 4000))
    return Error{"the servo rate must be 100 to 4000 Hz"};
  if (const Status fits = check_symmetry(settings.symmetry); !fits) return Error{fits.error()};
  if (const Status fits = check_brush(settings.brush, true); !fits) return Error{fits.error()};
  if (settings.materials.empty() || settings.materials.size() > kMaxMaterials)
    return Error{"there must be 1 to 64 materials"};
  if (const Status fits =
          ServoHand::check(settings, settings.model, settings.rate_hz, device->capabilities());
      !fits)
    return Error{fits.error()};
  if (second) {
    if (const Status fits = ServoHand::check(settings.second, settings.model, settings.rate_hz,
                                             second->capabilities());
        !fits)
      return Error{fits.error()};
    if (const Status fits = check_modes(Mode::cut, settings.second.mode, false); !fits)
      return Error{fits.error()};
  }
  model->reserve(ServoContext::kReadyTiles);
  return std::unique_ptr<LiveCarving>(
      new LiveCarving(std::move(model), std::move(device), settings, std::move(second)));
}

LiveCarving::~LiveCarving() {
  stop();
  Command* command = nullptr;
  while (commands_.pop(command) || cancels_.pop(command)) delete command;
  while (finished_.pop(command)) delete command;
}

void LiveCarving::start() {
  if (thread_.joinable()) return;
  stopping_ = false;
  thread_ = std::thread([this] {
    scheduling_ = enter_real_time();
    if (context_.settings_.armed) context_.for_hands([](ServoHand& hand) { hand.safety().arm(); });
    ServoClock clock(context_.settings_.rate_hz);
    while (!stopping_.load(std::memory_order_relaxed)) {
      const double elapsed = clock.wait();
      run_tick(elapsed);
      clock.done();
    }
    context_.for_hands([](ServoHand& hand) { hand.device().write({}); });
    context_.finish_stroke();
    statistics_ = clock.statistics();
  });
}

void LiveCarving::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  thread_.join();
  context_.for_hands([](ServoHand& hand) { hand.safety().disarm(); });
}

void LiveCarving::check_stopped() const { KIBORI_CHECK(!thread_.joinable()); }

ServoContext& LiveCarving::context() {
  check_stopped();
  return context_;
}

const ServoStatistics& LiveCarving::statistics() const {
  check_stopped();
  return statistics_;
}

const std::string& LiveCarving::scheduling() const {
  check_stopped();
  return scheduling_;
}

const LiveTotals& LiveCarving::totals() const {
  check_stopped();
  return context_.totals_;
}

bool LiveCarving::put(SmallQueue<Command*>& queue, Command command) {
  const std::lock_guard<std::mutex> lock(posting_);
  Command* done = nullptr;
  while (finished_.pop(done)) delete done;
  auto own = std::make_unique<Command>(std::move(command));
  if (!queue.push(own.get())) return false;
  static_cast<void>(own.release());
  return true;
}

bool LiveCarving::post(std::function<void(ServoContext&)> command, bool ends_stroke) {
  return put(commands_, {std::move(command), ends_stroke});
}

bool LiveCarving::cancel_stroke(std::function<void(ServoContext&)> then) {
  return put(cancels_, {std::move(then), false});
}

void LiveCarving::run_cancels() {
  Command* command = nullptr;
  while (cancels_.pop(command)) {
    context_.discard_stroke();
    if (command->run) command->run(context_);
    finished_.push(command);
  }
}

void LiveCarving::run_command() {
  Command* const* const next = commands_.front();
  if (!next) return;
  if ((*next)->ends_stroke) {
    if (!context_.settle()) return;
    context_.end_stroke();
    if (!context_.crumbs_.idle()) return;  // the search for severed pieces comes first
  }
  Command* command = nullptr;
  if (!commands_.pop(command)) return;
  command->run(context_);
  // finished_ has room for the commands of both other queues. Each call that adds a command to them
  // empties finished_ first. Therefore, it is never full.
  finished_.push(command);
}

LiveTick LiveCarving::tick(double elapsed_s) {
  LiveTick result = tick_at_once(elapsed_s);
  context_.crumbs_.wait();
  return result;
}

LiveTick LiveCarving::tick_at_once(double elapsed_s) {
  check_stopped();
  return run_tick(elapsed_s);
}

LiveTick LiveCarving::run_tick(double elapsed_s) {
  // Cancels come first: a command could end the stroke.
  run_cancels();
  // Severed pieces are removed before a command runs or another stroke begins.
  context_.take_crumbs();
  run_command();
  LiveTick result = context_.tick(elapsed_s);
  const TriDexel& model = *context_.model_;
  const auto every = static_cast<uint64_t>(std::max(1, context_.settings_.snapshot_ticks));
  if (++ticks_ % every == 0 && published_ != model.generation()) {
    published_ = model.generation();
    snapshots_.put({model.snapshot(), context_.body_.id});
  }
  return result;
}

}  // namespace kibori
