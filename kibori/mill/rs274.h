// SPDX-License-Identifier: MIT
// LinuxCNC's interpreter `rs274` as a child process. It translates programs with parameters,
// expressions, O-words and cutter radius compensation, which Kibori's own interpreter refuses.
//
//   program ─► lines with their numbers ─► rs274 -g ─► canonical listing ─► Program
//
// The listing repeats the N word of a line, so every line gets its line number as N word. The child
// runs in a temporary folder, without a shell, with limits of time and output.
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
  // A program with a loop that does not end would run forever.
  double max_seconds = 300;
  uint64_t max_bytes = kMaxProgramBytes;
  const std::atomic<bool>* stop = nullptr;  // see ChildOptions
};

// Opens a program. If it needs LinuxCNC's interpreter and `rs274` is in PATH, the program is
// translated first. Without `rs274`, next() reports the word that needs it. `tools`: for the
// diameters of cutter radius compensation. Errors: those of Program::open; the first two lines of
// what rs274 says, with file and line; a limit that it exceeds.
Result<std::unique_ptr<Program>> open_program(const std::filesystem::path& path,
                                              const InterpreterOptions& options,
                                              const std::vector<MillTool>& tools,
                                              const Rs274Limits& limits = {});

// A line of a program with `number` as its N word and without its comments: LinuxCNC can open files
// by comments, as (LOGOPEN,file). Lines of O-words, and lines that have no room for a number, keep
// their N word.
std::string with_line_number(const std::string& text, int number);

}  // namespace kibori
