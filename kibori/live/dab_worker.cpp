// SPDX-License-Identifier: MIT
#include <kibori/live/dab_worker.h>

#include <algorithm>
#include <utility>

#include <kibori/base/check.h>

namespace kibori {

DabWorker::DabWorker(std::function<void()> after_change, int threads)
    : after_change_(std::move(after_change)), threads_(threads), thread_([this] { run(); }) {}

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
  if (strokes_.full()) return false;
  stroke.number = ++number_;
  sent_ = stroke.start;
  keeps_newest_ = warps(stroke.settings.mode);
  merge_tolerance_mm_ = kMergeTolerance * stroke.state.lattice.pitch_mm;
  // A brush is round, so only the path of its tip counts (PoseMerger).
  const Mode mode = stroke.settings.mode;
  merge_reach_mm_ = mode == Mode::press || on_wheel(mode) ? reach_mm(stroke.settings.tool) : 0;
  merge_from_sent();
  strokes_.push(std::move(stroke));
  return true;
}

// Begins the next merged motion.
void DabWorker::merge_from_sent() {
  merged_.begin(sent_, merge_tolerance_mm_, merge_reach_mm_, sent_pressure_);
}

bool DabWorker::push(const Pose& pose, double pressure, bool ends) {
  if (!waiting_.push({number_, pose, pressure, ends})) return false;
  moves_++;
  sent_ = pose;
  sent_pressure_ = pressure;
  merge_from_sent();
  signal();
  return true;
}

bool DabWorker::move(const Pose& pose, double pressure) {
  if (!crowded()) return flush() && push(pose, pressure, false);
  if (keeps_newest_) merge_from_sent();
  return merged_.add(pose, pressure) || (flush() && merged_.add(pose, pressure));
}

bool DabWorker::flush() {
  return merged_.empty() || push(merged_.end(), merged_.end_pressure(), false);
}

bool DabWorker::end() { return flush() && push(sent_, sent_pressure_, true); }

size_t DabWorker::queued() const {
  return static_cast<size_t>(moves_ - answered_.load(std::memory_order_acquire));
}

bool DabWorker::crowded() const { return queued() >= kMaxMoves / 2 || strokes_.full(); }

size_t DabWorker::pending() const { return queued() + (merged_.empty() ? 0 : 1); }

bool DabWorker::take(Done& done) {
  while (done_.pop(done)) {
    signal();  // the worker may wait for room in done_
    if (!is_dropped(done.stroke)) return true;
  }
  return false;
}

void DabWorker::drop() {
  dropped_.store(number_, std::memory_order_release);
  merge_from_sent();
  signal();
}

bool DabWorker::settled() const { return pending() == 0; }

void DabWorker::run() {
  while (!stopping_) {
    const int seen = signals_.load(std::memory_order_acquire);
    Move move;
    while (!stopping_ && !done_.full() && waiting_.pop(move)) {
      work(move);
      answered_.fetch_add(1, std::memory_order_release);
    }
    if (bench_ && is_dropped(stroke_.number)) clear_bench();
    if (!stopping_) signals_.wait(seen, std::memory_order_acquire);
  }
}

void DabWorker::clear_bench() {
  bench_.reset();
  if (memory_->bytes() > kMaxKeptBytes) memory_ = std::make_shared<DabMemory>();
}

// Abandons the current stroke.
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
  // If a newer pose is waiting, the warp of this pose would be discarded.
  if (warps(mode) && !move.ends && !waiting_.empty()) return;
  auto& [model, reshape] = *bench_;
  // Until something changes, every move begins the stroke again. So the recorded stroke starts at
  // the first change.
  if (!changed_ && !reshape.begin(stroke_.settings, *stroke_.materials, last_)) {
    give_up();
    return;
  }
  Done done;
  done.stroke = move.stroke;
  done.ends = move.ends;
  done.before = last_;
  done.result =
      moved_tick({last_, move.pose.tip - last_.tip, rotation_between(last_.frame, move.pose.frame)},
                 move.pose.tip);
  done.result.pressure = move.pressure;
  const uint64_t before = model.generation();
  if (!(move.ends ? reshape.end(done.result) : reshape.advance(done.result, true))) {
    give_up();
    return;
  }
  done.changed = model.generation() != before;
  changed_ |= done.changed;
  if (done.changed && after_change_) after_change_();
  // If the result depends on the stroke's first pose, keep that pose, even if the first change
  // comes late.
  if (changed_ || !reshape.holds_start()) last_ = done.result.pose;
  if (!changed_) return;
  done.work_per_mm = reshape.work_per_mm();
  done.stiffness_n_mm = reshape.stiffness_n_mm();
  done.pending_mm3 = move.ends ? reshape.pending_mm3() : 0;
  if (done.changed) {
    done.state = model.snapshot();
    done.bounds = model.material_bounds();
  }
  // run() has seen that there is room.
  KIBORI_CHECK(done_.push(std::move(done)));
}

}  // namespace kibori
