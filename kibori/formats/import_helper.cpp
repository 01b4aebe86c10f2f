// SPDX-License-Identifier: MIT
#include <kibori/formats/import_helper.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
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

#include <kibori/base/file.h>
#include <kibori/base/memory.h>
#include <kibori/base/tolerances.h>

extern char** environ;

namespace kibori {
namespace {

constexpr int kResultHandle = 3;             // the memory file's handle in the helper
constexpr uint64_t kMaxNoteBytes = 1 << 14;  // max size of all notes of a mesh
constexpr uint64_t kMaxNameBytes = 1 << 24;  // max size of all names of a volume's labels
constexpr int kMaxVoxelsAlong = 2048;
constexpr char kMeshMagic[8] = {'K', 'I', 'B', 'M', 'E', 'S', 'H', '1'};
constexpr char kVolumeMagic[8] = {'K', 'I', 'B', 'V', 'O', 'L', 'U', '1'};

// Head of the memory file of a mesh. The vertices, the triangles and the notes follow it. Each note
// ends with a line feed.
struct MeshHead {
  char magic[8];
  uint64_t vertices, triangles;
};
// Head of the memory file of a volume. The labels of the voxels follow it, and then the names. Each
// name is a line: the label, a space, the name.
struct VolumeHead {
  char magic[8];
  int32_t size[3];
  uint32_t padding = 0;
  double voxel_mm[3];
};

// The size of a file [bytes]. A .gltf file has its data in .bin files next to it. Their names are
// unknown here, so all .bin files of the folder are added.
double bytes_of(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  const auto size = [](const fs::path& file) {
    std::error_code failed;
    const auto bytes = fs::file_size(file, failed);
    return failed ? 0 : static_cast<double>(bytes);
  };
  double bytes = size(path);
  if (ending_of(path) != ".gltf") return bytes;
  std::error_code error;
  fs::directory_iterator file(path.parent_path().empty() ? "." : path.parent_path(), error);
  for (; !error && file != fs::directory_iterator(); file.increment(error))
    if (ending_of(file->path()) == ".bin") bytes += size(file->path());
  return bytes;
}

// The time limit for a file [s]. Every parser reads several megabytes per second, so 1 s per MB is
// ample.
double seconds_for(const std::filesystem::path& path) { return 10 + bytes_of(path) * 1e-6; }

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

// End of a message about a failure that is a bug of Kibori, not a fault of the file.
constexpr const char* kOurFault =
    ", which is a bug of Kibori, not of the file; please report it, and use another format until "
    "it is fixed";

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

// Reads the head of the memory file. `bytes` receives the file's size.
template <class Head>
bool read_head(int handle, const char (&magic)[8], Head& head, uint64_t& bytes) {
  const off_t size = lseek(handle, 0, SEEK_END);
  if (size < 0 || lseek(handle, 0, SEEK_SET) != 0 || !read_all(handle, &head, sizeof head) ||
      std::memcmp(head.magic, magic, sizeof magic) != 0)
    return false;
  bytes = static_cast<uint64_t>(size);
  return true;
}

// Reads the mesh that the helper wrote to the memory file. All counts, coordinates and indices are
// checked, because a malicious file may control the helper.
Result<TriangleMesh> receive_mesh(int handle, const std::string& name,
                                  std::vector<std::string>* notes) {
  const Error broken{name + ": the importer returned an invalid mesh" + kOurFault};
  MeshHead head;
  uint64_t size = 0;
  if (!read_head(handle, kMeshMagic, head, size)) return broken;
  if (head.triangles > kMaxImportTriangles || head.vertices > 3 * kMaxImportTriangles)
    return Error{name + ": has more than 100 million triangles; export fewer"};
  TriangleMesh mesh;
  using Triangle = decltype(mesh.triangles)::value_type;
  static_assert(sizeof(Vec3) == 24 && sizeof(Triangle) == 12);
  const uint64_t before_notes =
      sizeof head + head.vertices * sizeof(Vec3) + head.triangles * sizeof(Triangle);
  if (size < before_notes || size - before_notes > kMaxNoteBytes) return broken;
  mesh.vertices.resize(head.vertices);
  mesh.triangles.resize(head.triangles);
  if (!read_all(handle, static_cast<void*>(mesh.vertices.data()), head.vertices * sizeof(Vec3)) ||
      !read_all(handle, mesh.triangles.data(), head.triangles * sizeof(Triangle)))
    return broken;
  for (const Vec3& p : mesh.vertices)
    if (!p.allFinite()) return Error{name + ": contains a coordinate that is not a finite number"};
  for (const Triangle& t : mesh.triangles)
    for (const uint32_t v : t)
      if (v >= head.vertices) return broken;
  std::string output(size - before_notes, '\0');
  if (!read_all(handle, output.data(), output.size())) return broken;
  for (size_t at = 0; notes && at < output.size();) {
    const size_t end = std::min(output.find('\n', at), output.size());
    notes->push_back(sanitize_message(output.substr(at, end - at)));
    at = end + 1;
  }
  return mesh;
}

// Reads and checks the volume that the helper wrote to the memory file.
Result<LabelVolume> receive_volume(int handle, const std::string& name) {
  const Error broken{name + ": the importer returned an invalid volume" + kOurFault};
  VolumeHead head;
  uint64_t bytes = 0;
  if (!read_head(handle, kVolumeMagic, head, bytes)) return broken;
  LabelVolume volume;
  uint64_t voxels = 1;
  for (int i = 0; i < 3; i++) {
    if (head.size[i] < 1 || head.size[i] > kMaxVoxelsAlong ||
        !(head.voxel_mm[i] > 0 && head.voxel_mm[i] < 1e9))
      return broken;
    volume.size[i] = head.size[i];
    volume.voxel_mm[i] = head.voxel_mm[i];
    voxels *= static_cast<uint64_t>(head.size[i]);
  }
  const uint64_t before_names = sizeof head + voxels * sizeof(uint16_t);
  if (bytes < before_names || bytes - before_names > kMaxNameBytes) return broken;
  volume.values.resize(voxels);
  if (!read_all(handle, volume.values.data(), voxels * sizeof(uint16_t))) return broken;
  std::string names(bytes - before_names, '\0');
  if (!read_all(handle, names.data(), names.size())) return broken;
  for (size_t at = 0; at < names.size();) {
    const size_t end = std::min(names.find('\n', at), names.size()),
                 space = std::min(names.find(' ', at), end);
    uint16_t label = 0;
    const auto [stop, error] = std::from_chars(names.data() + at, names.data() + space, label);
    if (error != std::errc() || stop != names.data() + space || space == end) return broken;
    volume.names[label] = sanitize_message(names.substr(space + 1, end - space - 1));
    at = end + 1;
  }
  return volume;
}

// Collects at most 4096 bytes of the helper's standard error until the helper closes it. Returns
// false if the time limit is reached first.
bool listen(int handle, double seconds, std::string& output) {
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
    output.append(text, static_cast<size_t>(std::min<ssize_t>(
                            got, static_cast<ssize_t>(4096 - output.size() % 4096))));
    if (output.size() > 4096) output.resize(4096);
  }
}

// Runs the helper on a file. If the helper succeeds, its result is in `memory`.
Status run_helper(const std::filesystem::path& path, const Handle& memory) {
  const std::string name = path.string();
  const std::string program = helper_program();
  int ends[2] = {-1, -1};
  const bool piped = pipe2(ends, O_CLOEXEC) == 0;
  Handle from(ends[0]), pipe_end(ends[1]);
  // Copies both handles to numbers above kResultHandle, so that dup2 below never copies a handle
  // onto itself. Such a copy keeps close-on-exec, and exec would close the handle.
  Handle to(fcntl(pipe_end.get(), F_DUPFD_CLOEXEC, kResultHandle + 1)),
      result(fcntl(memory.get(), F_DUPFD_CLOEXEC, kResultHandle + 1));
  if (!piped || to.get() < 0 || result.get() < 0)
    return Error{name + ": cannot be read because the process has too many open files"};

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, to.get(), STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&actions, result.get(), kResultHandle);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  std::string first = program, second = name;
  char* arguments[] = {first.data(), second.data(), nullptr};
  pid_t helper = -1;
  const int failed = posix_spawnp(&helper, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0)
    return Error{name + ": can't be read because the program '" + program + "' does not start (" +
                 std::strerror(failed) +
                 "); install it next to kibori or name it in KIBORI_IMPORT"};
  to.reset();
  pipe_end.reset();

  std::string output;
  const double seconds = seconds_for(path);
  const bool in_time = listen(from.get(), seconds, output);
  if (!in_time) kill(helper, SIGKILL);
  int status = 0;
  pid_t ended = -1;
  do ended = waitpid(helper, &status, 0);
  while (ended < 0 && errno == EINTR);
  // If SIGCHLD is ignored, the exit status is unknown. Then a message from the helper means that it
  // failed.
  if (ended < 0 && !output.empty()) status = 2 << 8;
  if (!in_time ||
      (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)))
    return Error{name + ": takes too long or too much memory to read (limit: " +
                 std::to_string(static_cast<int64_t>(seconds)) +
                 " s for a file of its size); export fewer triangles or voxels, or another format"};
  if (WIFSIGNALED(status))
    return Error{name + ": crashes the importer (signal " + std::to_string(WTERMSIG(status)) + ")" +
                 kOurFault};
  if (WEXITSTATUS(status) == 127)
    return Error{name + ": can't be read because '" + program +
                 "' does not start; install Kibori again"};
  if (WEXITSTATUS(status) != 0) {
    output.resize(std::min(output.find('\n'), output.size()));
    return Error{output.empty() ? name + ": can't be read" : sanitize_message(output)};
  }
  return Ok{};
}

#ifndef KIBORI_SANITIZED
// After this call, this process can read files below `folder`, and cannot open other files. If
// `folder` is null, it can open no file. Does nothing if the kernel has no Landlock.
void restrict_files(const std::filesystem::path* folder) {
  landlock_ruleset_attr nothing = {};
  // All access rights that Landlock's first version knows.
  nothing.handled_access_fs = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;
  const Handle rules(
      static_cast<int>(syscall(SYS_landlock_create_ruleset, &nothing, sizeof nothing, 0)));
  if (rules.get() < 0) return;
  if (folder) {
    const Handle parent(open(folder->c_str(), O_PATH | O_CLOEXEC));
    landlock_path_beneath_attr readable = {};
    readable.allowed_access = LANDLOCK_ACCESS_FS_READ_FILE;
    readable.parent_fd = parent.get();
    syscall(SYS_landlock_add_rule, rules.get(), LANDLOCK_RULE_PATH_BENEATH, &readable, 0);
  }
  syscall(SYS_landlock_restrict_self, rules.get(), 0);
}
#endif

Handle memory_file() { return Handle(memfd_create("import", MFD_CLOEXEC)); }

}  // namespace

Result<TriangleMesh> read_in_helper(const std::filesystem::path& path,
                                    std::vector<std::string>* notes) {
  const Handle memory = memory_file();
  if (Status fine = run_helper(path, memory); !fine) return Error{fine.error()};
  return receive_mesh(memory.get(), path.string(), notes);
}

Result<LabelVolume> read_volume_in_helper(const std::filesystem::path& path) {
  const Handle memory = memory_file();
  if (Status fine = run_helper(path, memory); !fine) return Error{fine.error()};
  return receive_volume(memory.get(), path.string());
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
  if (!std::filesystem::exists(path, error)) return true;  // the parser reports the error
  // A parser keeps several copies of a file in memory: as text, tokens and numbers.
  double memory = 1e9 + 200 * bytes_of(path);
  if (const double there = available_bytes(); there > 0)
    memory = std::min(memory, std::max(1e9, 0.8 * there));
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // after the caller has ended, nobody reads the result
#ifdef KIBORI_SANITIZED
  const bool bounded = true;  // sanitisers reserve terabytes of address space
#else
  const bool bounded = set(RLIMIT_AS, memory);
#endif
  return bounded && set(RLIMIT_CORE, 0) && set(RLIMIT_CPU, seconds_for(path));
}

void confine_helper_to([[maybe_unused]] const std::filesystem::path& folder) {
#ifndef KIBORI_SANITIZED  // sanitisers open files to report errors
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0) restrict_files(&folder);
#endif
}

void confine_helper() {
#ifndef KIBORI_SANITIZED
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return;
  restrict_files(nullptr);
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
  // The filter rejects all calls of another architecture, and x86-64's calls with 32-bit pointers.
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

bool send_mesh(const TriangleMesh& mesh, const std::vector<std::string>& notes) {
  MeshHead head;
  std::memcpy(head.magic, kMeshMagic, sizeof kMeshMagic);
  head.vertices = mesh.vertices.size();
  head.triangles = mesh.triangles.size();
  std::string output;
  for (const std::string& note : notes)
    if (output.size() + note.size() < kMaxNoteBytes) output.append(sanitize_message(note)) += '\n';
  return write_all(kResultHandle, &head, sizeof head) &&
         write_all(kResultHandle, mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3)) &&
         write_all(kResultHandle, mesh.triangles.data(), mesh.triangles.size() * 12) &&
         write_all(kResultHandle, output.data(), output.size());
}

bool send_volume(const LabelVolume& volume) {
  VolumeHead head;
  std::memcpy(head.magic, kVolumeMagic, sizeof kVolumeMagic);
  for (int i = 0; i < 3; i++) {
    head.size[i] = volume.size[i];
    head.voxel_mm[i] = volume.voxel_mm[i];
  }
  std::string names;
  for (const auto& [label, name] : volume.names)
    names.append(std::to_string(label)).append(" ").append(sanitize_message(name)) += '\n';
  if (names.size() > kMaxNameBytes) names.clear();
  return write_all(kResultHandle, &head, sizeof head) &&
         write_all(kResultHandle, volume.values.data(), volume.values.size() * sizeof(uint16_t)) &&
         write_all(kResultHandle, names.data(), names.size());
}

}  // namespace kibori
