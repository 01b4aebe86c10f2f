// SPDX-License-Identifier: MIT
#include <kibori/document/file_lock.h>

#include <cerrno>
#include <chrono>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kibori {

namespace {

std::filesystem::path lock_of(const std::filesystem::path& path) {
  std::error_code code;
  const std::filesystem::path real = std::filesystem::weakly_canonical(path, code);
  return (code ? path : real).string() + "-lock";
}

}  // namespace

bool FileLock::held(const std::filesystem::path& path) {
  const int file = ::open(lock_of(path).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  // If the lock's file exists but this user may not read it, another user's process holds it.
  if (file < 0) return errno == EACCES;
  const bool held = ::flock(file, LOCK_SH | LOCK_NB) != 0;
  ::close(file);
  return held;
}

Result<FileLock> FileLock::take(const std::filesystem::path& path) {
  std::error_code code;
  const std::string name = sanitize_message(path.string());
  FileLock lock;
  lock.path_ = lock_of(path);
  // held() of another process may hold the lock for an instant. So the attempt is repeated.
  int refused = 0;
  // Retries if the previous holder has removed the file in the meantime.
  for (int i = 0; i < 100; i++) {
    const int file = ::open(lock.path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (file < 0 && errno == EACCES && std::filesystem::exists(lock.path_, code))
      return Error{name + ": its lock " + sanitize_message(lock.path_) +
                   " belongs to another user; close the document there, or remove that file"};
    if (file < 0) return Error{name + ": cannot be opened for writing"};
    // Users who may write the document may also lock it.
    struct stat document = {};
    if (::stat(path.c_str(), &document) == 0)
      static_cast<void>(::fchmod(file, document.st_mode & 0666));
    if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
      ::close(file);
      if (++refused < 10) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        continue;
      }
      return Error{
          name + ": another process has it open for writing; open it read-only, or close it there"};
    }
    struct stat held = {}, there = {};
    if (::fstat(file, &held) == 0 && ::stat(lock.path_.c_str(), &there) == 0 &&
        held.st_ino == there.st_ino) {
      lock.file_ = file;
      return lock;
    }
    ::close(file);
  }
  return Error{name + ": cannot be opened for writing"};
}

void FileLock::release() {
  if (file_ < 0) return;
  ::unlink(path_.c_str());
  ::close(file_);
  file_ = -1;
}

}  // namespace kibori
