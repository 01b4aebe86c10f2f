// SPDX-License-Identifier: MIT
#include <kibori/base/child.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace kibori {
namespace {

constexpr size_t kMaxErrors = 4096;
// Maximum number of bytes of one read from a pipe.
constexpr size_t kChunk = size_t{1} << 16;
// Interval of a look at ChildOptions::stop [ms].
constexpr int64_t kStopInterval = 50;

// A pipe whose ends close at exec.
class Pipe {
 public:
  Pipe() {
    open_ = pipe2(ends_.data(), O_CLOEXEC) == 0;
    // Moves the ends to numbers above those of the standard streams. Otherwise `become` might
    // dup2 a handle onto itself, which keeps close-on-exec.
    for (int& end : ends_)
      if (open_ && end <= STDERR_FILENO) {
        const int moved = fcntl(end, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
        close(std::exchange(end, moved));
        open_ = moved >= 0;
      }
  }
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  bool is_open() const { return open_; }
  int from() const { return ends_[0]; }
  int to() const { return ends_[1]; }
  void close_end(size_t end) {
    if (ends_[end] >= 0) close(ends_[end]);
    ends_[end] = -1;
  }

 private:
  std::array<int, 2> ends_ = {-1, -1};
  bool open_ = false;
};

// Runs in the new process, after fork(). Calls only functions that are safe there
// (signal-safety(7)).
[[noreturn]] void become(const char* program, char* const* arguments, const char* folder,
                         const Pipe& out, const Pipe& errors, const Pipe& failure) {
  setpgid(0, 0);                     // a new group, so that one signal also ends its children
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // ends this process if its caller ends
  const int input = open("/dev/null", O_RDONLY);
  if (input >= 0 && dup2(input, STDIN_FILENO) >= 0 && dup2(out.to(), STDOUT_FILENO) >= 0 &&
      dup2(errors.to(), STDERR_FILENO) >= 0 && (*folder == 0 || chdir(folder) == 0))
    execve(program, arguments, environ);
  const int reason = errno;
  static_cast<void>(!write(failure.to(), &reason, sizeof reason));
  _exit(127);
}

// Returns 0, or the reason why the program does not start.
int start(pid_t& child, const std::filesystem::path& program,
          const std::vector<std::string>& arguments, const ChildOptions& options, const Pipe& out,
          const Pipe& errors) {
  std::vector<std::string> texts = {program.string()};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(texts.size() + 1);
  for (std::string& text : texts) argv.push_back(text.data());
  argv.push_back(nullptr);
  Pipe failure;
  if (!failure.is_open()) return errno;
  child = fork();
  if (child < 0) return errno;
  if (child == 0)
    become(program.c_str(), argv.data(), options.folder.c_str(), out, errors, failure);
  setpgid(child, child);  // also here: the group must exist before run_child can kill it
  failure.close_end(1);
  int reason = 0;
  ssize_t got = 0;
  do got = read(failure.from(), &reason, sizeof reason);
  while (got < 0 && errno == EINTR);
  if (got <= 0) return 0;  // exec has closed the pipe
  while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) continue;
  return reason;
}

// Sets limits of the kernel. They also apply if this process ends before its child.
void limit(pid_t child, const ChildOptions& options) {
  const auto set = [&](auto what, uint64_t max) {
    const rlimit limits{max, max};
    prlimit(child, what, &limits, nullptr);
  };
  set(RLIMIT_CPU, static_cast<uint64_t>(std::ceil(options.max_seconds)));
  set(RLIMIT_FSIZE, options.max_file);
  set(RLIMIT_CORE, 0);
}

using Time = std::chrono::steady_clock::time_point;

// Reads both pipes until the child closes them.
Result<ChildEnd::Kind> listen(const ChildOptions& options, const Pipe& out, const Pipe& errors,
                              Time end, std::string& error_text) {
  std::array<pollfd, 2> pipes = {pollfd{out.from(), POLLIN, 0}, pollfd{errors.from(), POLLIN, 0}};
  std::vector<char> chunk(kChunk);
  uint64_t bytes = 0;
  while (pipes[0].fd >= 0 || pipes[1].fd >= 0) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    if (left.count() <= 0 || (options.stop && *options.stop)) return ChildEnd::Kind::too_slow;
    const int64_t wait =
        std::min<int64_t>(left.count() + 1, options.stop ? kStopInterval : 1 << 30);
    const int ready = poll(pipes.data(), pipes.size(), static_cast<int>(wait));
    if (ready < 0 && errno != EINTR) return Error{"its output cannot be read"};
    if (ready <= 0) continue;
    for (size_t i = 0; i < pipes.size(); i++) {
      if (pipes[i].fd < 0 || pipes[i].revents == 0) continue;
      const ssize_t got = read(pipes[i].fd, chunk.data(), chunk.size());
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
        pipes[i].fd = -1;
        continue;
      }
      const std::string_view text(chunk.data(), static_cast<size_t>(got));
      if (i == 1) {
        error_text.append(text.substr(0, kMaxErrors - std::min(kMaxErrors, error_text.size())));
        continue;
      }
      bytes += text.size();
      if (bytes > options.max_output) return ChildEnd::Kind::too_much;
      if (!options.output) continue;
      if (const Status taken = options.output(text); !taken) return Error{taken.error()};
    }
  }
  return ChildEnd::Kind::exited;
}

// Waits for the end of a child that may have closed its output before. Returns false if it does not
// end in time.
bool wait_until(pid_t child, Time end, int& status, bool& known) {
  constexpr auto kPause = std::chrono::milliseconds(5);
  while (true) {
    const pid_t waited = waitpid(child, &status, WNOHANG);
    // If SIGCHLD is ignored, the exit status is unknown.
    known = waited == child;
    if (known || (waited < 0 && errno != EINTR)) return true;
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(kPause);
  }
}

}  // namespace

std::optional<std::filesystem::path> find_program(const std::string& name) {
  const char* const list = std::getenv("PATH");
  std::string_view rest = list ? list : "";
  while (!rest.empty()) {
    const size_t end = std::min(rest.find(':'), rest.size());
    const std::filesystem::path file = std::filesystem::path(rest.substr(0, end)) / name;
    rest.remove_prefix(std::min(end + 1, rest.size()));
    std::error_code error;
    // A relative folder depends on the working directory, so it is not searched.
    if (file.is_absolute() && std::filesystem::is_regular_file(file, error) &&
        access(file.c_str(), X_OK) == 0)
      return file;
  }
  return std::nullopt;
}

Result<ChildEnd> run_child(const std::filesystem::path& program,
                           const std::vector<std::string>& arguments, const ChildOptions& options) {
  Pipe out, errors;
  if (!out.is_open() || !errors.is_open()) return Error{"the process has too many open files"};
  pid_t child = -1;
  if (const int failed = start(child, program, arguments, options, out, errors); failed != 0)
    return Error{program.string() + " does not start: " + std::strerror(failed)};
  limit(child, options);
  out.close_end(1);
  errors.close_end(1);
  const Time end =
      std::chrono::steady_clock::now() + std::chrono::duration_cast<Time::duration>(
                                             std::chrono::duration<double>(options.max_seconds));
  ChildEnd ended;
  const Result<ChildEnd::Kind> listened = listen(options, out, errors, end, ended.errors);
  int status = 0;
  bool known = false;
  if (listened) {
    ended.kind = listened.value();
    if (ended.kind == ChildEnd::Kind::exited && !wait_until(child, end, status, known))
      ended.kind = ChildEnd::Kind::too_slow;
  }
  if (!listened || ended.kind != ChildEnd::Kind::exited) {
    kill(-child, SIGKILL);
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  }
  if (!listened) return Error{listened.error()};
  if (ended.kind != ChildEnd::Kind::exited || !known) return ended;
  if (WIFSIGNALED(status)) {
    ended.code = WTERMSIG(status);
    ended.kind = ended.code == SIGXCPU ? ChildEnd::Kind::too_slow : ChildEnd::Kind::crashed;
  } else {
    ended.code = WEXITSTATUS(status);
  }
  return ended;
}

}  // namespace kibori
