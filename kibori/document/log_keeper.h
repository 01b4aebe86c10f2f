// SPDX-License-Identifier: MIT
// The thread that brings what a document's log holds onto the disk and into the file itself. It has its own
// connection, so that whoever writes never waits for the disk. Internal to `document`.
#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

namespace kibori {

class LogKeeper {
 public:
  // `vfs`: as of Database::open.
  explicit LogKeeper(std::filesystem::path file, const char* vfs = nullptr);
  ~LogKeeper();
  LogKeeper(const LogKeeper&) = delete;

  // Something was committed; within half a second it is on the disk, if that keeps up.
  void wrote() { wrote_ = true; }

 private:
  void run(const std::filesystem::path& file, const char* vfs);

  std::atomic<bool> wrote_{false};
  bool ends_ = false;
  std::mutex mutex_;
  std::condition_variable woken_;
  std::thread thread_;
};

}  // namespace kibori
