// SPDX-License-Identifier: MIT
#include <kibori/live/dab_worker.h>

#include <algorithm>
#include <utility>

#include <kibori/base/check.h>

namespace kibori {

DabWorker::DabWorker(int threads) : threads_(threads), thread_([this] { run(); }) {}

int DabWorker::spare_threads() {
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()) - 2, 1, 4);
}

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

bool DabWorker::move(const Pose& pose, bool ends) {
  if (!waiting_.push({number_, pose, ends})) return false;
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
    if (bench_ && is_dropped(stroke_.number)) clear_bench();
    if (!stopping_) signals_.wait(seen, std::memory_order_acquire);
  }
}

void DabWorker::clear_bench() {
  bench_.reset();
  if (memory_->bytes() > kMostKept) memory_ = std::make_shared<DabMemory>();
}

// No more of this stroke.
void DabWorker::give_up() {
  clear_bench();
  Done done;
  done.stroke = stroke_.number;
  done.failed = true;
  KIBORI_CHECK(done_.push(std::move(done)));
}

void DabWorker::work(const Move& move) {
  if (move.stroke != stroke_.number) {
    while (stroke_.number < move.stroke && strokes_.pop(stroke_)) {
    }
    clear_bench();
    if (!is_dropped(move.stroke)) bench_ = std::make_unique<Bench>(stroke_, threads_, memory_);
    stroke_.state = {};
    last_ = stroke_.start;
    changed_ = false;
  }
  if (!bench_ || is_dropped(move.stroke)) return;
  const Mode mode = stroke_.settings.mode;
  // A warp of a pose that is already left would be thrown away.
  if (warps(mode) && !move.ends && !waiting_.empty()) return;
  auto& [model, reshape] = *bench_;
  // Until something changes, the stroke begins anew with every move: its log begins there.
  if (!changed_ && !reshape.begin(stroke_.settings, *stroke_.materials, last_)) {
    give_up();
    return;
  }
  Done done;
  done.stroke = move.stroke;
  done.ends = move.ends;
  done.before = last_;
  done.felt =
      moved_tick({last_, move.pose.tip - last_.tip, rotation_between(last_.frame, move.pose.frame)},
                 move.pose.tip);
  const uint64_t before = model.generation();
  if (!(move.ends ? reshape.end(done.felt) : reshape.advance(done.felt, true))) {
    give_up();
    return;
  }
  done.changed = model.generation() != before;
  changed_ |= done.changed;
  // A warp's stroke begins where it was begun, however late it changes anything.
  if (!warps(mode) || changed_) last_ = done.felt.pose;
  if (!changed_) return;
  done.work_per_mm = reshape.work_per_mm();
  done.stiffness_n_mm = reshape.stiffness_n_mm();
  done.owed_mm3 = move.ends ? reshape.owed_mm3() : 0;
  if (done.changed) {
    done.state = model.snapshot();
    done.bounds = model.material_bounds();
  }
  // The servo takes all there are before it adds a move, so this is never full.
  KIBORI_CHECK(done_.push(std::move(done)));
}

}  // namespace kibori
