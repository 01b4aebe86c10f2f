// SPDX-License-Identifier: MIT
#include <kibori/base/file.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kibori {

namespace {

// The permissions that the user's umask removes from new files. The function reads it from /proc,
// because umask() can only read it by setting it, which affects all threads.
mode_t umask_of_process() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (unsigned mask = 0; std::sscanf(line.c_str(), "Umask: %o", &mask) == 1) return mask;
  return 0077;
}

// Some file systems need no sync, and return an error for it.
bool synced(int handle) {
  return fsync(handle) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP;
}

// Sets the permissions that the user's umask gives to a new file.
void permit_as_new(const std::filesystem::path& path) {
  chmod(path.c_str(), 0666 & ~umask_of_process());
}

}  // namespace

Result<std::filesystem::path> make_sibling(const std::filesystem::path& path) {
  std::string name = path.string() + ".XXXXXX.part";
  const int handle = mkostemps(name.data(), 5, O_CLOEXEC);
  if (handle < 0)
    return Error{path.string() +
                 ": can't be written (no such folder, no permission, or no space left)"};
  close(handle);
  return std::filesystem::path(name);
}

std::filesystem::path place_of(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::path at = std::filesystem::absolute(path, error);
  for (int i = 0; i < 40 && std::filesystem::is_symlink(at, error); i++)
    at = at.parent_path() / std::filesystem::read_symlink(at, error);
  const std::filesystem::path real = std::filesystem::weakly_canonical(at, error);
  return error ? at.lexically_normal() : real;
}

bool sync_to_disk(const std::filesystem::path& path) {
  const int handle = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (handle < 0) return false;
  const bool done = synced(handle);
  close(handle);
  return done;
}

bool sync_name(const std::filesystem::path& path) {
  return sync_to_disk(place_of(path).parent_path());
}

NewFile::NewFile(const std::filesystem::path& path) : path_(path) {
  std::error_code error;
  const auto there = std::filesystem::status(path, error);
  folder_ = std::filesystem::is_directory(there);
  direct_ = std::filesystem::exists(there) && !folder_ && !std::filesystem::is_regular_file(there);
  // A link to a pipe, such as /dev/fd/63, has no named target. So only other links are followed.
  if (!direct_ && std::filesystem::is_symlink(path, error)) path_ = place_of(path);
  if (direct_)
    part_ = path_;
  else if (!folder_)
    if (const auto sibling = make_sibling(path_); sibling) part_ = sibling.value();
  if (!part_.empty()) file_ = std::fopen(part_.c_str(), "wb");
  failed_ = !file_;
}

NewFile::~NewFile() {
  if (!file_) return;
  std::fclose(file_);
  std::error_code error;
  if (!direct_) std::filesystem::remove(part_, error);
}

void NewFile::write(const void* data, size_t bytes) {
  if (!failed_) failed_ = std::fwrite(data, 1, bytes, file_) != bytes;
  size_ += bytes;
}

void NewFile::overwrite(uint64_t at, const void* data, size_t bytes) {
  if (failed_) return;
  failed_ = fseeko(file_, static_cast<off_t>(at), SEEK_SET) != 0 ||
            std::fwrite(data, 1, bytes, file_) != bytes || fseeko(file_, 0, SEEK_END) != 0;
}

Status NewFile::commit() {
  if (folder_) return Error{path_.string() + ": is a folder; name a file"};
  std::error_code error;
  if (file_ && !direct_) failed_ |= std::fflush(file_) != 0 || !synced(fileno(file_));
  if (file_ && std::fclose(std::exchange(file_, nullptr)) != 0) failed_ = true;
  if (failed_) {
    if (!direct_) std::filesystem::remove(part_, error);
    return Error{path_.string() +
                 ": can't be written (no such folder, no permission, or no space left)"};
  }
  if (direct_) return Ok{};
  // The new file gets the permissions of the file that it replaces.
  struct stat was = {};
  if (stat(path_.c_str(), &was) == 0)
    chmod(part_.c_str(), was.st_mode & 0777);
  else
    permit_as_new(part_);
  std::filesystem::rename(part_, path_, error);
  if (!error) {
    sync_name(path_);
    return Ok{};
  }
  const std::string reason = error.message();
  std::filesystem::remove(part_, error);
  return Error{path_.string() + ": can't be written: " + reason};
}

Spool::Spool(const std::filesystem::path& sibling) {
  std::string name = sibling.string() + ".spool.XXXXXX";
  const int handle = mkstemp(name.data());
  if (handle >= 0) {
    unlink(name.c_str());
    file_ = fdopen(handle, "w+b");
    if (!file_) close(handle);
  }
  failed_ = !file_;
}

Spool::~Spool() {
  if (file_) std::fclose(file_);
}

void Spool::write(const void* data, size_t bytes) {
  if (!failed_) failed_ = std::fwrite(data, 1, bytes, file_) != bytes;
  size_ += bytes;
}

bool Spool::read_back(size_t unit, const std::function<void(const char*, size_t)>& f, uint64_t from,
                      uint64_t max_bytes) {
  if (failed_ || fseeko(file_, static_cast<off_t>(from), SEEK_SET) != 0) return false;
  std::vector<char> block((size_t{1} << 20) / unit * unit);
  for (uint64_t left = std::min(max_bytes, size_ - std::min(from, size_)); left > 0;) {
    const size_t bytes = static_cast<size_t>(std::min<uint64_t>(left, block.size()));
    if (std::fread(block.data(), 1, bytes, file_) != bytes) return false;
    f(block.data(), bytes);
    left -= bytes;
  }
  return true;
}

Result<std::shared_ptr<TemporaryFolder>> TemporaryFolder::make() {
  std::error_code error;
  std::string name = (std::filesystem::temp_directory_path(error) / "kibori-XXXXXX").string();
  if (error || !mkdtemp(name.data()))
    return Error{"the temporary folder is not writable; set TMPDIR to a writable folder"};
  return std::shared_ptr<TemporaryFolder>(new TemporaryFolder(name));
}

namespace {

struct OpenFolders {
  std::mutex mutex;
  std::set<std::filesystem::path> paths;
};
OpenFolders& open_folders() {
  static auto& folders = *new OpenFolders;  // outlives every folder
  return folders;
}

}  // namespace

TemporaryFolder::TemporaryFolder(std::filesystem::path path) : path_(std::move(path)) {
  const std::lock_guard lock(open_folders().mutex);
  open_folders().paths.insert(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
  const std::lock_guard lock(open_folders().mutex);
  open_folders().paths.erase(path_);
}

void TemporaryFolder::remove_all() {
  std::error_code error;
  const std::lock_guard lock(open_folders().mutex);
  for (const std::filesystem::path& path : open_folders().paths)
    std::filesystem::remove_all(path, error);
}

Result<std::vector<char>> read_file(const std::filesystem::path& path, uint64_t max) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    return Error{path.string() + ": there is no such file"};
  if (!std::filesystem::is_regular_file(path, error))
    return Error{path.string() + ": is not a regular file but a folder, a pipe or a device"};
  const uint64_t size = std::filesystem::file_size(path, error);
  if (!error && size > max)
    return Error{path.string() + ": has " + std::to_string(size) + " bytes; at most " +
                 std::to_string(max) + " are read"};
  std::ifstream file(path, std::ios::binary);
  std::vector<char> bytes(error ? 0 : size);
  if (!file || error || !file.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
    return Error{path.string() + ": can't be read"};
  return bytes;
}

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

Status check_writable(const std::filesystem::path& path) {
  std::error_code error;
  const auto there = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(there))
    return Error{path.string() + ": is a folder; name a file"};
  // Devices and pipes are written directly.
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there))
    return access(path.c_str(), W_OK) == 0 ? Status(Ok{})
                                           : Status(Error{path.string() + ": is not writable"});
  const std::filesystem::path folder = place_of(path).parent_path();
  if (!std::filesystem::is_directory(folder, error))
    return Error{path.string() + ": the folder " + folder.string() + " does not exist"};
  if (access(folder.c_str(), W_OK) != 0)
    return Error{path.string() + ": the folder is not writable"};
  return Ok{};
}

}  // namespace kibori
