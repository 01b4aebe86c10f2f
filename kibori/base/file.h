// SPDX-License-Identifier: MIT
// Writes a file so that either the whole file appears, or none. Also temporary files and folders.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <kibori/base/result.h>

namespace kibori {

// Creates a new, empty file next to `path`. Its name is unpredictable, and only this user may read
// it. Error: one sentence that names `path`.
Result<std::filesystem::path> make_sibling(const std::filesystem::path& path);
// The absolute path of a file that exists or will be created. Links are followed, also links to
// files that do not exist yet.
std::filesystem::path place_of(const std::filesystem::path& path);
// Waits until a file is on the disk. Returns false if that failed.
bool sync_to_disk(const std::filesystem::path& path);
// Waits until the file's name, which is stored in its folder, is on the disk.
bool sync_name(const std::filesystem::path& path);

// Writes a temporary file next to the target. On commit, it waits until the data is on the disk,
// and then moves the file into place. Without a commit, the old file stays. If several writers
// write the same file at once, the file of the last commit remains, complete. Links are followed.
// Devices and pipes are written directly.
class NewFile {
 public:
  explicit NewFile(const std::filesystem::path& path);
  ~NewFile();
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  // Buffered; commit reports errors.
  void write(const void* data, size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  // Number of bytes written so far.
  uint64_t size() const { return size_; }
  // Overwrites earlier bytes. The next write continues at the end.
  void overwrite(uint64_t at, const void* data, size_t bytes);
  // Returns one sentence that names the file if anything failed.
  Status commit();

 private:
  std::filesystem::path path_, part_;
  std::FILE* file_ = nullptr;
  uint64_t size_ = 0;
  bool folder_ = false, direct_ = false, failed_ = false;
};

// Bytes stored temporarily on disk, next to the file `sibling`. They are deleted with the object,
// or when the process ends.
class Spool {
 public:
  explicit Spool(const std::filesystem::path& sibling);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  void write(const void* data, size_t bytes);
  uint64_t size() const { return size_; }
  // Calls f(data, bytes) for at most `max_bytes` bytes from offset `from`. The data is in order, in
  // blocks of a multiple of `unit` bytes. Returns false if a write or a read failed.
  bool read_back(size_t unit, const std::function<void(const char*, size_t)>& f, uint64_t from = 0,
                 uint64_t max_bytes = UINT64_MAX);

 private:
  std::FILE* file_ = nullptr;
  uint64_t size_ = 0;
  bool failed_ = false;
};

// A new folder in the system's temporary folder, which only this user can read. It is deleted with
// its contents when the object is destroyed.
class TemporaryFolder {
 public:
  // Error: no temporary folder is writable.
  static Result<std::shared_ptr<TemporaryFolder>> make();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // Removes all folders of this process, before it ends without destroying its objects. Any thread.
  static void remove_all();

 private:
  explicit TemporaryFolder(std::filesystem::path path);
  const std::filesystem::path path_;
};

// Reads a whole file. Errors: it does not exist, cannot be read, or has more bytes than `max`. Also
// if it is not a regular file, because a pipe or a device may never end.
Result<std::vector<char>> read_file(const std::filesystem::path& path,
                                    uint64_t max = uint64_t{1} << 40);

// The path's ending in lower case, with its dot.
std::string ending_of(const std::filesystem::path& path);

// Ok if a file can be created at `path`, otherwise one sentence. Call it before long work, so that
// the error appears early.
Status check_writable(const std::filesystem::path& path);

}  // namespace kibori
