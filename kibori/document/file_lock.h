// SPDX-License-Identifier: MIT
// A lock that allows only one writer per document. It locks a file next to the document. SQLite's
// own locks are not enough: SQLite holds them only briefly, and loses them if this process opens
// and closes the database once more. Internal to `document`.
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

  // Locks the file `path`-lock. The destructor removes this file. Errors: another process holds the
  // lock; the file cannot be created. Messages name `path`.
  static Result<FileLock> take(const std::filesystem::path& path);
  // Returns true if a process holds the lock of `path`.
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
