// SPDX-License-Identifier: MIT
// Runs long work on its own thread, so that the server continues. One job at a time.
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
  // Handles the result on the server's thread. `wanted`: the job was not cancelled meanwhile.
  using Then = std::function<void(bool wanted)>;

  explicit Job(net::Loop& loop) : loop_(loop) {}
  // Waits for all running work. Its Then is not called.
  ~Job();

  // True if no job can start: one is running, or too many cancelled ones have not ended yet.
  bool busy() const { return !what_.empty() || threads_.size() > 2; }
  // The running job. Empty: none.
  const std::string& what() const { return what_; }
  bool cancellable() const { return cancellable_; }
  // Progress from 0 to 1. Below 0: unknown.
  double share() const { return share_ ? share_->load() : -1; }
  // Calls work(share) on a thread; `work` may set the progress. The server's thread then calls the
  // returned Then. Requires !busy().
  void start(const std::string& what, bool cancellable,
             std::function<Then(std::atomic<double>&)> work);
  // Cancels the running job. Its work continues, but its result is not wanted.
  void cancel();
  // Waits for work that cannot be cancelled, and at most `time` for other work. Its Then is not
  // called. False if some work still runs.
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
