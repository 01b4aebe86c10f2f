// SPDX-License-Identifier: MIT
#include <kibori/live/crumb_worker.h>

#include <utility>

#include <kibori/base/check.h>
#include <kibori/live/dab_worker.h>

namespace kibori {

CrumbWorker::CrumbWorker() : thread_([this] { run(); }) {}

CrumbWorker::~CrumbWorker() {
  stopping_ = true;
  signal();
  thread_.join();
}

void CrumbWorker::signal() {
  signals_.fetch_add(1, std::memory_order_release);
  signals_.notify_one();
}

void CrumbWorker::begin(Stroke stroke) {
  KIBORI_CHECK(idle_ && strokes_.push(std::move(stroke)));
  idle_ = false;
  request_count_++;
  signal();
}

void CrumbWorker::wait() const {
  for (int answered; (answered = answers_.load(std::memory_order_acquire)) != request_count_;)
    answers_.wait(answered, std::memory_order_acquire);
}

bool CrumbWorker::take(Done& done) {
  if (!done_.pop(done)) return false;
  idle_ = true;
  return true;
}

void CrumbWorker::run() {
  while (!stopping_) {
    const int seen = signals_.load(std::memory_order_acquire);
    Stroke stroke;
    while (!stopping_ && strokes_.pop(stroke)) {
      Done done;
      {
        TriDexel model(stroke.after, stroke.bounds);
        const uint64_t was = model.generation();
        done.crumbs = take_crumbs(model, stroke.before, stroke.rule, stroke.no_go.get(),
                                  DabWorker::spare_threads());
        done.changed = model.generation() != was;
        if (done.changed) stroke.after = model.snapshot();
      }
      stroke.no_go.reset();
      done.stroke = std::move(stroke);
      KIBORI_CHECK(done_.push(std::move(done)));
      answers_.fetch_add(1, std::memory_order_release);
      answers_.notify_one();
    }
    if (!stopping_) signals_.wait(seen, std::memory_order_acquire);
  }
}

}  // namespace kibori
