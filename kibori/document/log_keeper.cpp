// SPDX-License-Identifier: MIT
#include <kibori/document/log_keeper.h>

#include <chrono>
#include <optional>
#include <utility>

#include <kibori/document/database.h>

namespace kibori {
namespace {

// A loss of power, or of the log, takes what was written within this time.
constexpr auto kEvery = std::chrono::milliseconds(500);

}  // namespace

LogKeeper::LogKeeper(std::filesystem::path file, const char* vfs)
    : thread_([this, file = std::move(file), vfs] { run(file, vfs); }) {}

LogKeeper::~LogKeeper() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  woken_.notify_one();
  thread_.join();
}

void LogKeeper::run(const std::filesystem::path& file, const char* vfs) {
  std::optional<Database> database;
  std::unique_lock lock(mutex_);
  while (!woken_.wait_for(lock, kEvery, [this] { return ends_; })) {
    if (!wrote_.exchange(false)) continue;
    lock.unlock();
    if (!database)
      if (Result<Database> opened = Database::open(file, Database::Access::write, vfs); opened)
        database = std::move(opened).value();
    // The log is synced first. What readers still need stays in it, until the next time.
    if (!database || !database->run("PRAGMA wal_checkpoint(PASSIVE)")) wrote_ = true;
    lock.lock();
  }
}

}  // namespace kibori
