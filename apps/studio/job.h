// SPDX-License-Identifier: MIT
// What takes long, on a thread of its own, so that the server goes on meanwhile: one at a time.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <boost/asio/io_context.hpp>

namespace kibori::studio {

class Job {
 public:
  // What is done with the outcome, on the server's thread; `wanted`: it was not cancelled
  // meanwhile.
  using Then = std::function<void(bool wanted)>;

  explicit Job(boost::asio::io_context& io) : io_(io) {}
  // Waits for running work; its Then is not called.
  ~Job();

  // Whether nothing more can be started: something is under way, or too much that was cancelled has
  // not ended.
  bool busy() const { return !what_.empty() || threads_.size() > 2; }
  // What is under way; empty: nothing.
  const std::string& what() const { return what_; }
  bool cancellable() const { return cancellable_; }
  // How much of it is done, 0 to 1; below 0: not known.
  double share() const { return share_ ? share_->load() : -1; }
  // Calls work(share) on its thread, which may set that, and then what it returns. Only where it is
  // not busy.
  void start(const std::string& what, bool cancellable,
             std::function<Then(std::atomic<double>&)> work);
  // Nothing is under way any more: work goes on, but its outcome is not wanted.
  void cancel();
  // Waits until all threads have ended; their Then is not called.
  void wait();

 private:
  boost::asio::io_context& io_;
  std::string what_;
  bool cancellable_ = true;
  std::shared_ptr<bool> wanted_;
  std::shared_ptr<std::atomic<double>> share_;
  std::vector<std::thread> threads_;
};

}  // namespace kibori::studio
