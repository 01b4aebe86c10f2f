// SPDX-License-Identifier: MIT
// One writer a document: a lock on a file beside it. SQLite's own locks are for moments, and
// closing any other descriptor of a database would drop them. Internal to `document`.
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

  // Holds `path`-lock, which is gone again when this is. Errors: another holds it; it can't be
  // made. They name `path`.
  static Result<FileLock> take(const std::filesystem::path& path);

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
