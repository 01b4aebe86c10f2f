// SPDX-License-Identifier: MIT
// The thread that brings what a document's log holds onto the disk and into the file itself. It has
// its own connection, so that whoever writes never waits for the disk. Internal to `document`.
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

  // Something was committed; within half a second it is on the disk, if the disk keeps up.
  void wrote() { wrote_ = true; }

 private:
  void run();

  Database database_;  // of the thread
  std::atomic<bool> wrote_{false};
  bool ends_ = false;
  std::mutex mutex_;  // ends_
  std::condition_variable woken_;
  std::thread thread_;  // begins when all else is there
};

}  // namespace kibori
