// SPDX-License-Identifier: MIT
#include <kibori/formats/import_helper.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <kibori/base/memory.h>
#include <kibori/base/tolerances.h>

extern char** environ;

namespace kibori {
namespace {

constexpr int kMeshHandle = 3;  // of the memory file, in the helper
constexpr char kMagic[8] = {'K', 'I', 'B', 'M', 'E', 'S', 'H', '1'};

struct Head {
  char magic[8];
  uint64_t vertices, triangles;
};

// Parsers get through megabytes a second; this is far more than any needs.
double seconds_for(const std::filesystem::path& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return 10 + (error ? 0 : static_cast<double>(size) * 1e-6);
}

std::string helper_program() {
  if (const char* named = std::getenv("KIBORI_IMPORT")) return named;
  std::error_code error;
  const auto here =
      std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "kibori-import";
  if (!error && access(here.c_str(), X_OK) == 0) return here;
  return "kibori-import";
}

class Handle {
 public:
  explicit Handle(int number) : number_(number) {}
  ~Handle() { reset(); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  int get() const { return number_; }
  void reset() {
    if (number_ >= 0) close(number_);
    number_ = -1;
  }

 private:
  int number_;
};

bool write_all(int handle, const void* data, size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t written = write(handle, at, bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    at += written;
    bytes -= static_cast<size_t>(written);
  }
  return true;
}
bool read_all(int handle, void* data, size_t bytes) {
  char* at = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t got = read(handle, at, bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    bytes -= static_cast<size_t>(got);
  }
  return true;
}

// What the helper left in the memory file; nothing in it is believed unseen.
Result<TriangleMesh> receive_mesh(int handle, const std::string& name) {
  const Error broken{name + ": the importer gave no proper mesh; the file is damaged or hostile"};
  Head head;
  const off_t size = lseek(handle, 0, SEEK_END);
  if (size < 0 || lseek(handle, 0, SEEK_SET) != 0 || !read_all(handle, &head, sizeof head) ||
      std::memcmp(head.magic, kMagic, sizeof kMagic) != 0)
    return broken;
  if (head.triangles > kMaxImportTriangles || head.vertices > 3 * kMaxImportTriangles)
    return Error{name + ": holds more triangles than can be taken"};
  TriangleMesh mesh;
  using Triangle = decltype(mesh.triangles)::value_type;
  static_assert(sizeof(Vec3) == 24 && sizeof(Triangle) == 12);
  if (static_cast<uint64_t>(size) !=
      sizeof head + head.vertices * sizeof(Vec3) + head.triangles * sizeof(Triangle))
    return broken;
  mesh.vertices.resize(head.vertices);
  mesh.triangles.resize(head.triangles);
  if (!read_all(handle, static_cast<void*>(mesh.vertices.data()), head.vertices * sizeof(Vec3)) ||
      !read_all(handle, mesh.triangles.data(), head.triangles * sizeof(Triangle)))
    return broken;
  for (const Vec3& p : mesh.vertices)
    if (!p.allFinite()) return Error{name + ": holds a coordinate that is not a finite number"};
  for (const Triangle& t : mesh.triangles)
    for (const uint32_t v : t)
      if (v >= head.vertices) return broken;
  return mesh;
}

// What the helper says on its standard error, until it closes it or the time is up (false).
bool listen(int handle, double seconds, std::string& said) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd one{handle, POLLIN, 0};
    const int ready = poll(&one, 1, static_cast<int>(std::min<int64_t>(left.count(), 1 << 30)));
    if (ready < 0 && errno != EINTR) return false;
    if (ready <= 0) continue;
    char text[4096];
    const ssize_t got = read(handle, text, sizeof text);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return true;
    said.append(text, static_cast<size_t>(
                          std::min<ssize_t>(got, static_cast<ssize_t>(4096 - said.size() % 4096))));
    if (said.size() > 4096) said.resize(4096);
  }
}

}  // namespace

Result<TriangleMesh> read_in_helper(const std::filesystem::path& path) {
  const std::string name = path.string();
  const std::string program = helper_program();
  int ends[2] = {-1, -1};
  const bool piped = pipe2(ends, O_CLOEXEC) == 0;
  Handle from(ends[0]), pipe_end(ends[1]), memory(memfd_create("mesh", MFD_CLOEXEC));
  // Out of the way of the helper's own numbers: dup2 onto itself would leave a handle to be closed
  // by exec.
  Handle to(fcntl(pipe_end.get(), F_DUPFD_CLOEXEC, kMeshHandle + 1)),
      mesh(fcntl(memory.get(), F_DUPFD_CLOEXEC, kMeshHandle + 1));
  if (!piped || to.get() < 0 || mesh.get() < 0)
    return Error{name + ": no handles left to read it with"};

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, to.get(), STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&actions, mesh.get(), kMeshHandle);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  std::string first = program, second = name;
  char* arguments[] = {first.data(), second.data(), nullptr};
  pid_t helper = -1;
  const int failed = posix_spawnp(&helper, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0)
    return Error{name + ": can't be read because the program '" + program + "' does not start (" +
                 std::strerror(failed) + "); install it beside kibori or name it in KIBORI_IMPORT"};
  to.reset();
  pipe_end.reset();

  std::string said;
  const double seconds = seconds_for(path);
  const bool in_time = listen(from.get(), seconds, said);
  if (!in_time) kill(helper, SIGKILL);
  int status = 0;
  pid_t ended = -1;
  do ended = waitpid(helper, &status, 0);
  while (ended < 0 && errno == EINTR);
  // Where SIGCHLD is ignored nobody knows how it ended, but for what it said.
  if (ended < 0 && !said.empty()) status = 2 << 8;
  if (!in_time ||
      (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)))
    return Error{name + ": takes too long or too much memory to read; it is damaged or hostile"};
  if (WIFSIGNALED(status))
    return Error{name + ": crashes the importer (signal " + std::to_string(WTERMSIG(status)) +
                 "); it is damaged or hostile"};
  if (WEXITSTATUS(status) == 127)
    return Error{name + ": can't be read because '" + program + "' does not start"};
  if (WEXITSTATUS(status) != 0) {
    said.resize(std::min(said.find('\n'), said.size()));
    return Error{said.empty() ? name + ": can't be read" : sanitize_message(said)};
  }
  return receive_mesh(mesh.get(), name);
}

bool limit_helper(const std::filesystem::path& path) {
  const auto set = [](auto what, double max) {
    rlimit limit;
    if (getrlimit(what, &limit) != 0) return false;
    limit.rlim_cur = limit.rlim_max =
        std::min(static_cast<rlim_t>(max), limit.rlim_max);  // it may be lower already
    return setrlimit(what, &limit) == 0;
  };
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) return true;  // the parser will say what is wrong
  // Parsers hold a file several times over, as text, tokens and numbers.
  double memory = 1e9 + 200 * static_cast<double>(size);
  if (const double there = available_bytes(); there > 0)
    memory = std::min(memory, std::max(1e9, 0.8 * there));
#ifdef KIBORI_SANITIZED
  const bool bounded = true;  // sanitisers reserve address space by the terabyte
#else
  const bool bounded = set(RLIMIT_AS, memory);
#endif
  return bounded && set(RLIMIT_CORE, 0) && set(RLIMIT_CPU, seconds_for(path));
}

void confine_helper() {
#ifndef KIBORI_SANITIZED  // sanitisers open files when they have something to tell
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return;
  landlock_ruleset_attr nothing = {};
  // All that its first version knows.
  nothing.handled_access_fs = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;
  const long rules = syscall(SYS_landlock_create_ruleset, &nothing, sizeof nothing, 0);
  if (rules >= 0) {
    syscall(SYS_landlock_restrict_self, rules, 0);
    close(static_cast<int>(rules));
  }
#if defined(__x86_64__)
  constexpr uint32_t kMachine = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
  constexpr uint32_t kMachine = AUDIT_ARCH_AARCH64;
#else
  constexpr uint32_t kMachine = 0;
#endif
  if (kMachine == 0) return;
  const uint32_t refused[] = {
#ifdef SYS_open
      SYS_open,
      SYS_creat,
      SYS_fork,
      SYS_vfork,
#endif
      SYS_openat,
      SYS_openat2,
      SYS_open_by_handle_at,
      SYS_socket,
      SYS_connect,
      SYS_execve,
      SYS_execveat,
      SYS_ptrace,
      SYS_process_vm_readv,
      SYS_process_vm_writev,
      SYS_io_uring_setup,
      SYS_kill,
      SYS_tkill};
  // Of another machine's calls none are known: they are refused, and so are x86-64's with short
  // pointers.
  std::vector<sock_filter> filter = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kMachine, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, 0x40000000, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM)};
  for (const uint32_t call : refused) {
    filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1));
    filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM));
  }
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  const sock_fprog program = {static_cast<unsigned short>(filter.size()), filter.data()};
  prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0);
#endif
}

bool send_mesh(const TriangleMesh& mesh) {
  Head head;
  std::memcpy(head.magic, kMagic, sizeof kMagic);
  head.vertices = mesh.vertices.size();
  head.triangles = mesh.triangles.size();
  return write_all(kMeshHandle, &head, sizeof head) &&
         write_all(kMeshHandle, mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3)) &&
         write_all(kMeshHandle, mesh.triangles.data(), mesh.triangles.size() * 12);
}

}  // namespace kibori
