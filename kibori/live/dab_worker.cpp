// SPDX-License-Identifier: MIT
#include <kibori/live/dab_worker.h>

#include <utility>

#include <kibori/base/check.h>

namespace kibori {

DabWorker::DabWorker() : thread_([this] { run(); }) {}

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

bool DabWorker::move(const Vec3& tip) {
  if (!waiting_.push({number_, tip})) return false;
  moves_++;
  signal();
  return true;
}

bool DabWorker::take(Done& done) {
  while (done_.pop(done))
    if (!is_dropped(done.stroke)) return true;
  return false;
}

void DabWorker::drop() {
  dropped_.store(number_, std::memory_order_release);
  signal();
}

bool DabWorker::settled() const { return answered_.load(std::memory_order_acquire) == moves_; }

void DabWorker::run() {
  while (!stopping_) {
    const int seen = signals_.load(std::memory_order_acquire);
    Move move;
    while (!stopping_ && waiting_.pop(move)) {
      work(move);
      answered_.fetch_add(1, std::memory_order_release);
    }
    if (bench_ && is_dropped(stroke_.number)) bench_.reset();
    if (!stopping_) signals_.wait(seen, std::memory_order_acquire);
  }
}

void DabWorker::work(const Move& move) {
  if (move.stroke != stroke_.number) {
    while (stroke_.number < move.stroke && strokes_.pop(stroke_)) {
    }
    bench_ = is_dropped(move.stroke) ? nullptr : std::make_unique<Bench>(stroke_);
    stroke_.state = {};
    last_ = stroke_.start.tip;
    changed_ = false;
  }
  if (!bench_ || is_dropped(move.stroke)) return;
  auto& [model, dabs] = *bench_;
  if (!changed_) dabs.begin(last_);
  Done done;
  done.stroke = move.stroke;
  done.before = {last_, stroke_.start.frame};
  done.felt.pose = {move.tip, stroke_.start.frame};
  const uint64_t before = model.generation();
  if (!dabs.advance(stroke_.mode, stroke_.brush, stroke_.law, *stroke_.materials, stroke_.rate_hz,
                    done.felt)) {
    bench_.reset();  // no more of this stroke
    return;
  }
  last_ = move.tip;
  done.changed = model.generation() != before;
  changed_ |= done.changed;
  if (!changed_) return;
  done.work_per_mm = dabs.work_per_mm();
  if (done.changed) {
    done.state = model.snapshot();
    done.bounds = model.material_bounds();
  }
  // The servo takes all there are before it adds a move, so this is never full.
  KIBORI_CHECK(done_.push(std::move(done)));
}

}  // namespace kibori
