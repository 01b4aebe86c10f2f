// SPDX-License-Identifier: MIT
#include <kibori/live/dab_worker.h>

#include <utility>

#include <kibori/base/check.h>

namespace kibori {

DabWorker::DabWorker(const Snapshot& model, const LatticeBox& bounds)
    : model_(model, bounds), dabs_(model_), thread_([this] { run(); }) {}

DabWorker::~DabWorker() {
  drop();
  stopping_ = true;
  signal();
  thread_.join();
}

void DabWorker::signal() {
  signals_.fetch_add(1, std::memory_order_release);
  signals_.notify_one();
}

bool DabWorker::begin(Stroke stroke) {
  stroke.number = number_ + 1;
  if (!strokes_.push(std::move(stroke))) return false;
  number_++;
  return true;
}

void DabWorker::move(const Vec3& tip) {
  if (!waiting_.push({number_, tip})) return;
  moves_++;
  signal();
}

bool DabWorker::take(Done& done) {
  while (done_.pop(done))
    if (done.stroke > dropped_.load(std::memory_order_relaxed)) return true;
  return false;
}

void DabWorker::drop() { dropped_.store(number_, std::memory_order_release); }

bool DabWorker::settled() const { return answered_.load(std::memory_order_acquire) == moves_; }

void DabWorker::run() {
  while (!stopping_) {
    const int seen = signals_.load(std::memory_order_acquire);
    Move move;
    while (!stopping_ && waiting_.pop(move)) {
      work(move);
      answered_.fetch_add(1, std::memory_order_release);
    }
    if (!stopping_) signals_.wait(seen, std::memory_order_acquire);
  }
}

void DabWorker::work(const Move& move) {
  const auto dropped = [&] { return move.stroke <= dropped_.load(std::memory_order_acquire); };
  if (move.stroke != stroke_.number) {
    while (stroke_.number < move.stroke && strokes_.pop(stroke_)) {
    }
    model_.include_material(stroke_.bounds);
    model_.restore(stroke_.state);
    stroke_.state = {};
    last_ = stroke_.start.tip;
    dabs_.begin(last_);
    changed_ = failed_ = false;
  }
  if (dropped() || failed_) return;
  if (!changed_) dabs_.begin(last_);
  Done done;
  done.stroke = move.stroke;
  done.before = {last_, stroke_.start.frame};
  done.felt.pose = {move.tip, stroke_.start.frame};
  const uint64_t before = model_.generation();
  if (!dabs_.advance(stroke_.mode, stroke_.brush, stroke_.law, *stroke_.materials, stroke_.rate_hz,
                     done.felt)) {
    failed_ = true;
    return;
  }
  last_ = move.tip;
  done.changed = model_.generation() != before;
  changed_ |= done.changed;
  if (!changed_) return;
  done.work_per_mm = dabs_.work_per_mm();
  if (done.changed) {
    done.state = model_.snapshot();
    done.bounds = model_.material_bounds();
  }
  // The servo takes all there are before it adds a move, so this is never full.
  KIBORI_CHECK(done_.push(std::move(done)));
}

}  // namespace kibori
