// SPDX-License-Identifier: MIT
// Files that appear whole or not at all.
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

// A new, empty file beside `path`, in a name that nobody can foresee, for this user only. Error:
// one sentence that names `path`.
Result<std::filesystem::path> make_beside(const std::filesystem::path& path);
// Where a file is, or would be made: absolute, with links followed, also those to what is not there
// yet.
std::filesystem::path place_of(const std::filesystem::path& path);
// Waits until a file is on the disk; false where that failed.
bool sync_to_disk(const std::filesystem::path& path);
// The same for its name, which is its folder's.
bool sync_name(const std::filesystem::path& path);

// Writes beside the file and moves it into place on commit, when it is on the disk; without a
// commit, what was there stays. Of several who write the same file at once, the last to commit has
// all of it. Links are followed; devices and pipes are written to as they are.
class NewFile {
 public:
  explicit NewFile(const std::filesystem::path& path);
  ~NewFile();
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  // Buffered; an error shows at commit.
  void write(const void* data, size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  // Bytes written so far.
  uint64_t size() const { return size_; }
  // Writes over earlier bytes, and goes on at the end.
  void overwrite(uint64_t at, const void* data, size_t bytes);
  // One sentence naming the file if anything went wrong.
  Status commit();

 private:
  std::filesystem::path path_, part_;
  std::FILE* file_ = nullptr;
  uint64_t size_ = 0;
  bool folder_ = false, direct_ = false, failed_ = false;
};

// Bytes put aside on disk, beside the file they will end in; gone with the object, or the process.
class Spool {
 public:
  explicit Spool(const std::filesystem::path& beside);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  void write(const void* data, size_t bytes);
  uint64_t size() const { return size_; }
  // Calls f(data, bytes) for so many bytes from there, or all that were written, in order, in
  // blocks of whole multiples of `unit` bytes; false where writing or reading failed.
  bool read_back(size_t unit, const std::function<void(const char*, size_t)>& f, uint64_t from = 0,
                 uint64_t most = UINT64_MAX);

 private:
  std::FILE* file_ = nullptr;
  uint64_t size_ = 0;
  bool failed_ = false;
};

// A new folder in the temporary one that only this user can look into; gone with the object, and
// all that is in it.
class TemporaryFolder {
 public:
  // Error: there is none that can be written.
  static Result<std::shared_ptr<TemporaryFolder>> make();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::filesystem::path path) : path_(std::move(path)) {}
  const std::filesystem::path path_;
};

// A whole file. Errors: there is none, or it can't be read; it is no regular file (a pipe or a
// device may never end); it has more bytes than `max`.
Result<std::vector<char>> read_file(const std::filesystem::path& path,
                                    uint64_t max = uint64_t{1} << 40);

// The path's ending in lower case, with its dot.
std::string ending_of(const std::filesystem::path& path);

// Ok if a file can be made at `path`, else one sentence: better known before the work than after.
Status check_writable(const std::filesystem::path& path);

}  // namespace kibori
