// SPDX-License-Identifier: MIT
#include "apps/studio/job.h"

#include <boost/asio/post.hpp>

namespace kibori::studio {

Job::~Job() { wait(); }

void Job::wait() {
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void Job::start(const std::string& what, bool cancellable,
                std::function<Then(std::atomic<double>&)> work) {
  what_ = what;
  cancellable_ = cancellable;
  wanted_ = std::make_shared<bool>(true);
  share_ = std::make_shared<std::atomic<double>>(-1);
  threads_.emplace_back([this, wanted = wanted_, share = share_, work = std::move(work)] {
    Then then = work(*share);
    boost::asio::post(io_, [this, wanted, then = std::move(then), id = std::this_thread::get_id()] {
      for (size_t i = 0; i < threads_.size(); i++)
        if (threads_[i].get_id() == id) {
          threads_[i].join();
          threads_.erase(threads_.begin() + static_cast<std::ptrdiff_t>(i));
          break;
        }
      if (*wanted) what_.clear();
      then(*wanted);
    });
  });
}

void Job::cancel() {
  if (what_.empty() || !cancellable_) return;
  *wanted_ = false;
  what_.clear();
}

}  // namespace kibori::studio
