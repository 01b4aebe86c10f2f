// SPDX-License-Identifier: MIT
// A program, read line by line: G-code or a canonical listing, plain or compressed by gzip. The
// moves are streamed, so a program may be larger than the memory.
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

// Maximum size of a program's text [bytes]. A small compressed file may contain much more text.
inline constexpr uint64_t kMaxProgramBytes = uint64_t{1} << 33;

class Program {
 public:
  // Opens a file. Errors: it is not a regular file, or cannot be read.
  static Result<std::unique_ptr<Program>> open(const std::filesystem::path& path,
                                               InterpreterOptions options = {});
  // Opens a canonical listing that is the translation of the program `name`. The N words of the
  // listing are line numbers of that program. `warnings` are those of the translation. `keeps` is
  // an object that must live as long as the result, for example the folder of the listing. Errors:
  // the listing cannot be read.
  static Result<std::unique_ptr<Program>> open_translated(const std::filesystem::path& listing,
                                                          const std::string& name,
                                                          std::vector<ProgramWarning> warnings,
                                                          std::shared_ptr<void> keeps);
  // Opens a program in memory. `name` is its name in messages. `text` must outlive the result.
  static std::unique_ptr<Program> of_text(std::string name, std::string_view text,
                                          InterpreterOptions options = {});
  virtual ~Program() = default;

  // Executes lines until a line has moves, and appends these moves to `out`. Returns false after
  // the last line. Errors (with file and line): those of parse_gcode, Interpreter::run and
  // CanonListing::run; the file is damaged.
  virtual Result<bool> next(std::vector<CanonMove>& out) = 0;
  virtual std::vector<ProgramWarning> warnings() const = 0;
  virtual const std::string& name() const = 0;
  // Returns the number of the last line that was read.
  virtual int line() const = 0;
};

}  // namespace kibori
