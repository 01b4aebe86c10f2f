// SPDX-License-Identifier: MIT
// The thread that syncs a document's log to the disk and copies it into the file. It has its own
// connection, so the writer never waits for the disk. Internal to `document`.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include <kibori/document/database.h>

namespace kibori {

class LogKeeper {
 public:
  // `database`: another connection to the file that is written.
  explicit LogKeeper(Database database)
      : database_(std::move(database)), thread_([this] { run(); }) {}
  ~LogKeeper();
  LogKeeper(const LogKeeper&) = delete;

  // Call after a commit. The data is on the disk within half a second, if the disk is fast enough.
  void wrote() { wrote_ = true; }

 private:
  void run();

  Database database_;  // for the thread
  std::atomic<bool> wrote_{false};
  bool ends_ = false;
  std::mutex mutex_;  // guards ends_
  std::condition_variable woken_;
  std::thread thread_;  // starts after all other members exist
};

}  // namespace kibori
