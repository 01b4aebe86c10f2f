// SPDX-License-Identifier: MIT
// Writes files that appear complete or not at all. Also has temporary files and folders.
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

// Creates a new, empty file in the folder of `path`, and returns its path. The file's name is
// unpredictable, and only this user may read the file. Error: one sentence that names `path`.
Result<std::filesystem::path> make_sibling(const std::filesystem::path& path);
// Returns the absolute path of a file, which need not exist. Follows links, even if a link's target
// does not exist yet.
std::filesystem::path place_of(const std::filesystem::path& path);
// Waits until the content of a file is on the disk. Returns false on failure.
bool sync_to_disk(const std::filesystem::path& path);
// Waits until the name of a file is on the disk. The file's folder stores the name. Returns false
// on failure.
bool sync_name(const std::filesystem::path& path);

// Writes a file that appears complete or not at all. The data goes to a temporary file next to the
// target. commit() waits until the data is on the disk, and then moves the temporary file to the
// target. Without commit(), the target stays unchanged. If several writers write one target at the
// same time, the target gets the complete data of the last commit. If the target is a link, the
// file that the link points to is replaced. Data for devices and pipes is written directly.
class NewFile {
 public:
  explicit NewFile(const std::filesystem::path& path);
  ~NewFile();
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  // Appends data to a buffer. commit() reports errors.
  void write(const void* data, size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  // Number of bytes written so far.
  uint64_t size() const { return size_; }
  // Overwrites earlier bytes, from offset `at`. The next write() continues at the end.
  void overwrite(uint64_t at, const void* data, size_t bytes);
  // Completes the file. Error, if this or an earlier call failed: one sentence that names the file.
  Status commit();

 private:
  std::filesystem::path path_, part_;
  std::FILE* file_ = nullptr;
  uint64_t size_ = 0;
  bool folder_ = false, direct_ = false, failed_ = false;
};

// Bytes that are stored for some time in an unnamed file, in the folder of `sibling`. The system
// deletes them when the object is destroyed or the process ends.
class Spool {
 public:
  explicit Spool(const std::filesystem::path& sibling);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  void write(const void* data, size_t bytes);
  uint64_t size() const { return size_; }
  // Calls f(data, bytes) for up to `max_bytes` of the stored bytes, in order, from offset `from`.
  // The size of each block is a multiple of `unit` bytes. Only the last block may have another
  // size. Returns false if an earlier write failed, or a read fails.
  bool read_back(size_t unit, const std::function<void(const char*, size_t)>& f, uint64_t from = 0,
                 uint64_t max_bytes = UINT64_MAX);

 private:
  std::FILE* file_ = nullptr;
  uint64_t size_ = 0;
  bool failed_ = false;
};

// A new folder inside the system's temporary folder. Only this user can read the new folder. The
// destructor deletes it with its contents.
class TemporaryFolder {
 public:
  // Creates the folder. Error: the system's temporary folder is not writable.
  static Result<std::shared_ptr<TemporaryFolder>> make();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // Deletes the folders of all objects in this process. Call it if the process ends without
  // destroying these objects. Any thread.
  static void remove_all();

 private:
  explicit TemporaryFolder(std::filesystem::path path);
  const std::filesystem::path path_;
};

// Reads a whole file. Errors: the file does not exist, cannot be read, or has more than `max`
// bytes. A path to a pipe or a device is also an error, because its data may never end.
Result<std::vector<char>> read_file(const std::filesystem::path& path,
                                    uint64_t max = uint64_t{1} << 40);

// Returns the extension of a path in lower case, with its dot. Empty if there is none.
std::string ending_of(const std::filesystem::path& path);

// Checks that a file can be created at `path`. Error: one sentence. Call it before long work, so
// that the user sees the error early.
Status check_writable(const std::filesystem::path& path);

}  // namespace kibori
