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
  std::filesystem::path folder;             // its working directory
  double max_seconds = 60;                  // of real time, and of its processor time
  uint64_t max_output = uint64_t{1} << 30;  // bytes on standard output
  uint64_t max_file = uint64_t{1} << 24;    // bytes of each file that it writes
  const std::atomic<bool>* stop = nullptr;  // true ends the child as if it were too slow
  // Receives standard output, piece by piece. An error ends the child.
  std::function<Status(std::string_view)> output;
};

// How a child ended.
struct ChildEnd {
  enum class Kind { exited, crashed, too_slow, too_much } kind = Kind::exited;
  int code = 0;        // exit status, or the signal that ended it
  std::string errors;  // first 4 kB of standard error
};

// The path of a program in PATH; nullopt if there is none.
std::optional<std::filesystem::path> find_program(const std::string& name);

// Runs a program with these arguments until it ends. If it exceeds a limit, it and its own children
// are killed. Its standard input is empty. Errors: it does not start; an error of `output`.
Result<ChildEnd> run_child(const std::filesystem::path& program,
                           const std::vector<std::string>& arguments, const ChildOptions& options);

}  // namespace kibori
