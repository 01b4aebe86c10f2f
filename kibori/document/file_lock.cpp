// SPDX-License-Identifier: MIT
#include <kibori/document/file_lock.h>

#include <cerrno>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kibori {

Result<FileLock> FileLock::take(const std::filesystem::path& path) {
  std::error_code code;
  const std::string name = sanitize_message(path.string());
  const std::filesystem::path real = std::filesystem::weakly_canonical(path, code);
  FileLock lock;
  lock.path_ = (code ? path : real).string() + "-lock";
  // Again where whoever held it took the file away meanwhile.
  for (int i = 0; i < 100; i++) {
    const int file = ::open(lock.path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (file < 0 && errno == EACCES && std::filesystem::exists(lock.path_, code))
      return Error{name + ": its lock " + sanitize_message(lock.path_) +
                   " is another user's; close the document there, or remove that file"};
    if (file < 0) return Error{name + ": can't be opened for writing"};
    // Who may write the document may hold its lock.
    struct stat document = {};
    if (::stat(path.c_str(), &document) == 0)
      static_cast<void>(::fchmod(file, document.st_mode & 0666));
    if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
      ::close(file);
      return Error{name +
                   ": is being written by another process; open it for reading, or close it there"};
    }
    struct stat held = {}, there = {};
    if (::fstat(file, &held) == 0 && ::stat(lock.path_.c_str(), &there) == 0 &&
        held.st_ino == there.st_ino) {
      lock.file_ = file;
      return lock;
    }
    ::close(file);
  }
  return Error{name + ": can't be opened for writing"};
}

void FileLock::release() {
  if (file_ < 0) return;
  ::unlink(path_.c_str());
  ::close(file_);
  file_ = -1;
}

}  // namespace kibori
