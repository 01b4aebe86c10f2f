// SPDX-License-Identifier: MIT
// Counts instructions by single-stepping a forked copy of this process. The count is exact, uses
// the machine's own vector unit, and ignores other work. A repeated string instruction counts once
// per repetition. It handles about 10^6 instructions per second, so use it for short work.
#pragma once

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

namespace kibori_bench {

// The number of instructions that f() runs. -1 if the system does not allow tracing.
template <class F>
int64_t count_instructions(F&& f) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) return -1;
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(1);
    std::raise(SIGSTOP);
    f();
    std::raise(SIGUSR1);  // stops here for the tracer
    _exit(0);
  }
  int status = 0;
  int64_t count = -1;
  if (waitpid(child, &status, 0) == child && WIFSTOPPED(status)) {
    count = 0;
    while (ptrace(PTRACE_SINGLESTEP, child, nullptr, nullptr) == 0 &&
           waitpid(child, &status, 0) == child && WIFSTOPPED(status) && WSTOPSIG(status) == SIGTRAP)
      count++;
  }
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  return count;
}

}  // namespace kibori_bench
