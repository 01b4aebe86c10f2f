// SPDX-License-Identifier: MIT
// Runs another program and reads what it prints. No shell is involved.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>

namespace kibori {

struct ChildOptions {
  std::filesystem::path folder;             // working directory; empty: that of this process
  double max_seconds = 60;                  // limit for real time, and for processor time
  uint64_t max_output = uint64_t{1} << 30;  // limit for standard output [bytes]
  uint64_t max_file = uint64_t{1} << 24;    // limit for each file that the child writes [bytes]
  const std::atomic<bool>* stop = nullptr;  // when it becomes true, the child ends as too_slow
  // Receives standard output, piece by piece. If it returns an error, the child is killed.
  std::function<Status(std::string_view)> output;
};

// How a child ended. `too_slow`: because of max_seconds or `stop`. `too_much`: because of
// max_output.
struct ChildEnd {
  enum class Kind { exited, crashed, too_slow, too_much } kind = Kind::exited;
  int code = 0;        // exited: the exit status; crashed: the number of the signal
  std::string errors;  // the first 4 kB of standard error
};

// Returns the path of a program in one of the folders of PATH; nullopt if there is none. Relative
// folders are not searched.
std::optional<std::filesystem::path> find_program(const std::string& name);

// Runs a program with these arguments and waits until it ends. If the program exceeds a limit, it
// is killed, together with the processes that it started. Its standard input is empty. Errors: the
// program does not start; its output cannot be read; an error of `output`.
Result<ChildEnd> run_child(const std::filesystem::path& program,
                           const std::vector<std::string>& arguments, const ChildOptions& options);

}  // namespace kibori
