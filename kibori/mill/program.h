// SPDX-License-Identifier: MIT
// A program file, read line by line: G-code or a canonical listing, plain or compressed with gzip.
// Its moves stream, so a program may be larger than memory.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/mill/canon_move.h>
#include <kibori/mill/interpreter.h>

namespace kibori {

// Maximum size of a program's text [bytes]. A small compressed file may hold much more text.
inline constexpr uint64_t kMaxProgramBytes = uint64_t{1} << 33;

class Program {
 public:
  // Opens a file. Errors: it is not a regular file, or cannot be read.
  static Result<std::unique_ptr<Program>> open(const std::filesystem::path& path,
                                               InterpreterOptions options = {});
  // Opens a canonical listing that is the translation of the program `name`. Its N words are line
  // numbers of that program. `warnings`: of the translation. `keeps`: an object that must live as
  // long as the program, for example the listing's folder.
  static Result<std::unique_ptr<Program>> open_translated(const std::filesystem::path& listing,
                                                          const std::string& name,
                                                          std::vector<ProgramWarning> warnings,
                                                          std::shared_ptr<void> keeps);
  // A program in memory. `name`: for messages. `text` must outlive the program.
  static std::unique_ptr<Program> of_text(std::string name, std::string_view text,
                                          InterpreterOptions options = {});
  virtual ~Program() = default;

  // Executes lines until one has moves, and appends these. Returns false after the last line.
  // Errors: one sentence with file and line. See parse_gcode, Interpreter::run and
  // CanonListing::run.
  virtual Result<bool> next(std::vector<CanonMove>& out) = 0;
  virtual std::vector<ProgramWarning> warnings() const = 0;
  virtual const std::string& name() const = 0;
  // Number of the last line that was read.
  virtual int line() const = 0;
};

}  // namespace kibori
