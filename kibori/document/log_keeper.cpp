// SPDX-License-Identifier: MIT
#include <kibori/document/log_keeper.h>

#include <chrono>

namespace kibori {
namespace {

// A power failure, or the loss of the log, loses what was written within this time.
constexpr auto kEvery = std::chrono::milliseconds(500);

}  // namespace

LogKeeper::~LogKeeper() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  woken_.notify_one();
  thread_.join();
}

void LogKeeper::run() {
  std::unique_lock lock(mutex_);
  while (!woken_.wait_for(lock, kEvery, [this] { return ends_; })) {
    if (!wrote_.exchange(false)) continue;
    lock.unlock();
    // The log is synced first. Data that readers still need stays in it until the next time.
    if (!database_.run("PRAGMA wal_checkpoint(PASSIVE)")) wrote_ = true;
    lock.lock();
  }
}

}  // namespace kibori
