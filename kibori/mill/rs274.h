// SPDX-License-Identifier: MIT
// Runs LinuxCNC's interpreter `rs274` as a child process. It translates programs that Kibori's
// interpreter does not accept: with parameters, expressions, O-words or cutter radius compensation.
//
//   program ─► lines with their numbers ─► rs274 -g ─► canonical listing ─► Program
//
// A line of the listing has the N word of the program's line. Therefore, every line of the program
// gets its line number as N word. The child runs in a temporary folder, without a shell. Its time
// and its output are limited.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/mill/interpreter.h>
#include <kibori/mill/program.h>
#include <kibori/mill/tool_table.h>

namespace kibori {

struct Rs274Limits {
  // Time limit. Without it, a program with an endless loop would never stop.
  double max_seconds = 300;
  uint64_t max_bytes = kMaxProgramBytes;
  const std::atomic<bool>* stop = nullptr;  // see ChildOptions
};

// Opens a program. If the program needs LinuxCNC's interpreter and `rs274` is in PATH, translates
// the program first. If `rs274` is missing, next() returns an error that names the word. The
// diameters of `tools` are for cutter radius compensation. Errors: those of Program::open; rs274
// rejects the program (the message has its reason, file and line); rs274 exceeds a limit.
Result<std::unique_ptr<Program>> open_program(const std::filesystem::path& path,
                                              const InterpreterOptions& options,
                                              const std::vector<MillTool>& tools,
                                              const Rs274Limits& limits = {});

// Returns a line of a program with `number` as its N word, and without comments. (A comment such as
// (LOGOPEN,file) could make LinuxCNC open a file.) A line of O-words, or a line without room for a
// number, keeps its own N word.
std::string with_line_number(const std::string& text, int number);

}  // namespace kibori
