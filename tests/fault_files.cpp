// SPDX-License-Identifier: MIT
// Intercepts a program's calls that write files durably (LD_PRELOAD) and logs them: which file was
// synced, its size then, and which file was renamed. KIBORI_FILES_LOG: path of the log.
// KIBORI_FAIL_FSYNC: number of the fsync that fails.
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace {

void note(const char* what, const char* path, const char* to) {
  const char* const name = std::getenv("KIBORI_FILES_LOG");
  if (!name) return;
  struct stat about = {};
  const long long size = stat(path, &about) == 0 ? static_cast<long long>(about.st_size) : -1;
  char line[2 * PATH_MAX + 100];
  const int length = std::snprintf(line, sizeof line, "%s\t%s\t%s\t%lld\t%d\n", what, path, to,
                                   size, S_ISDIR(about.st_mode) ? 1 : 0);
  const int file = open(name, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (file < 0) return;
  static_cast<void>(!write(file, line, static_cast<size_t>(length)));
  close(file);
}

template <class F>
F next(const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

int synced(const char* name, int file) {
  static std::atomic<int> count{0};
  const char* const fails = std::getenv("KIBORI_FAIL_FSYNC");
  if (fails && ++count == std::atoi(fails)) {
    errno = EIO;
    return -1;
  }
  char link[64], path[PATH_MAX] = "";
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length > 0) note("sync", path, "");
  return next<int (*)(int)>(name)(file);
}

}  // namespace

extern "C" {

int fsync(int file) { return synced("fsync", file); }
int fdatasync(int file) { return synced("fdatasync", file); }

int rename(const char* from, const char* to) {
  note("name", from, to);
  return next<int (*)(const char*, const char*)>("rename")(from, to);
}
int link(const char* from, const char* to) {
  note("name", from, to);
  return next<int (*)(const char*, const char*)>("link")(from, to);
}
}
