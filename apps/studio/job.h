// SPDX-License-Identifier: MIT
// Runs long work on a separate thread, so that the server continues. There is one job at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <kibori/net/web.h>

namespace kibori::studio {

class Job {
 public:
  // Handles the result on the server's thread. `wanted` is false if the job was cancelled.
  using Then = std::function<void(bool wanted)>;

  explicit Job(net::Loop& loop) : loop_(loop) {}
  // Waits until all threads have ended. Does not call their Then.
  ~Job();

  // Returns true if no job can start: a job is running, or too many cancelled jobs have not ended
  // yet.
  bool busy() const { return !what_.empty() || threads_.size() > 2; }
  // Returns the name of the running job, or an empty text.
  const std::string& what() const { return what_; }
  bool cancellable() const { return cancellable_; }
  // Returns the progress of the job from 0 to 1. Below 0, it is unknown.
  double share() const { return share_ ? share_->load() : -1; }
  // Calls work(share) on a new thread. `work` may set `share`, which is the progress. Then the
  // server's thread calls the function that `work` returned. Precondition: !busy().
  void start(const std::string& what, bool cancellable,
             std::function<Then(std::atomic<double>&)> work);
  // Cancels the running job. Its thread continues, but its result is not wanted.
  void cancel();
  // Waits for jobs that cannot be cancelled, and at most `time` for other jobs. Does not call their
  // Then. Returns false if a job still runs.
  bool end_within(std::chrono::milliseconds time);

 private:
  net::Loop& loop_;
  std::string what_;
  bool cancellable_ = true;
  std::shared_ptr<bool> wanted_;
  std::shared_ptr<std::atomic<double>> share_;
  struct Running {
    std::thread thread;
    bool cancellable = true;
    std::shared_ptr<std::atomic<bool>> ended;
  };
  std::vector<Running> threads_;
};

}  // namespace kibori::studio
