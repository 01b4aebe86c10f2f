// SPDX-License-Identifier: MIT
// Allows one writer per document, by a lock on a file next to it. SQLite's own locks are held only
// briefly, and closing another descriptor of the database drops them. Internal to `document`.
#pragma once

#include <filesystem>
#include <utility>

#include <kibori/base/result.h>

namespace kibori {

class FileLock {
 public:
  FileLock() = default;
  ~FileLock() { release(); }
  FileLock(FileLock&& other) noexcept { swap(other); }
  FileLock& operator=(FileLock&& other) noexcept {
    swap(other);
    return *this;
  }

  // Locks `path`-lock. The destructor removes that file. Errors: another process holds the lock, or
  // the file cannot be created. Errors name `path`.
  static Result<FileLock> take(const std::filesystem::path& path);
  // True if a process holds the lock of `path`.
  static bool held(const std::filesystem::path& path);

 private:
  void swap(FileLock& other) noexcept {
    std::swap(file_, other.file_);
    std::swap(path_, other.path_);
  }
  void release();

  int file_ = -1;
  std::filesystem::path path_;
};

}  // namespace kibori
