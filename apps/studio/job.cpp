// SPDX-License-Identifier: MIT
#include "apps/studio/job.h"

#include <algorithm>

namespace kibori::studio {

Job::~Job() {
  for (Running& running : threads_) running.thread.join();
}

bool Job::end_within(std::chrono::milliseconds time) {
  const auto until = std::chrono::steady_clock::now() + time;
  for (Running& running : threads_)
    while (!*running.ended && (!running.cancellable || std::chrono::steady_clock::now() < until))
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return std::all_of(threads_.begin(), threads_.end(),
                     [](const Running& running) { return running.ended->load(); });
}

void Job::start(const std::string& what, bool cancellable,
                std::function<Then(std::atomic<double>&)> work) {
  what_ = what;
  cancellable_ = cancellable;
  wanted_ = std::make_shared<bool>(true);
  share_ = std::make_shared<std::atomic<double>>(-1);
  Running& running = threads_.emplace_back();
  running.cancellable = cancellable;
  running.ended = std::make_shared<std::atomic<bool>>(false);
  running.thread = std::thread(
      [this, wanted = wanted_, share = share_, ended = running.ended, work = std::move(work)] {
        Then then = work(*share);
        loop_.post([this, wanted, then = std::move(then), id = std::this_thread::get_id()] {
          for (size_t i = 0; i < threads_.size(); i++)
            if (threads_[i].thread.get_id() == id) {
              threads_[i].thread.join();
              threads_.erase(threads_.begin() + static_cast<std::ptrdiff_t>(i));
              break;
            }
          if (*wanted) what_.clear();
          then(*wanted);
        });
        *ended = true;
      });
}

void Job::cancel() {
  if (what_.empty() || !cancellable_) return;
  *wanted_ = false;
  what_.clear();
}

}  // namespace kibori::studio
