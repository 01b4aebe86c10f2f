// SPDX-License-Identifier: MIT
// The thread that writes a document's log to the disk, and copies the log into the file. The thread
// has its own connection, so that the writer never waits for the disk. Internal to `document`.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include <kibori/document/database.h>

namespace kibori {

class LogKeeper {
 public:
  // `database` must be another connection to the file.
  explicit LogKeeper(Database database)
      : database_(std::move(database)), thread_([this] { run(); }) {}
  ~LogKeeper();
  LogKeeper(const LogKeeper&) = delete;

  // Call this after a commit. Then the data is on the disk within about half a second, if the disk
  // is fast enough.
  void wrote() { wrote_ = true; }

 private:
  void run();

  Database database_;  // only the thread uses it
  std::atomic<bool> wrote_{false};
  bool ends_ = false;
  std::mutex mutex_;  // guards ends_
  std::condition_variable woken_;
  std::thread thread_;  // last member: the thread starts when the others exist
};

}  // namespace kibori
