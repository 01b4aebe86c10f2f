// SPDX-License-Identifier: MIT
// Milling line by line, for callers that compute the next line themselves, and for simulators of
// CAM programs. run_milling (milling.h) runs whole files. Both result in the same model.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/mill/canon_move.h>
#include <kibori/mill/gcode_parser.h>
#include <kibori/mill/tool_table.h>
#include <kibori/run/milling.h>

namespace kibori {

class MillSession {
 public:
  // `model` and the objects to which `options` points must outlive the session. Errors:
  // MillOptions::tool is not in the table.
  static Result<std::unique_ptr<MillSession>> begin(TriDexel& model, const MillOptions& options);
  ~MillSession();

  // Adds a tool or replaces the one with its number, and puts it into the spindle. Errors: a number
  // that is not 1 to 99999; those of check_tool.
  Status set_tool(const MillTool& tool);
  // Executes one line of G-code. `from`: the position of the machine before it; nullopt: the last
  // position. Modes remain until another line changes them. Errors: one sentence with the number of
  // the line. After an error, the moves before it are cut, and the modes are those before the line.
  Status apply(std::string_view line, const std::optional<AxisPosition>& from = std::nullopt);
  Status apply(const GcodeLine& line, const std::optional<AxisPosition>& from = std::nullopt);
  // Runs a program file. It begins with the default modes of the controller.
  Status run(const std::filesystem::path& program);

  // Position of the machine's axes after the last move, in the part's frame.
  const AxisPosition& at() const;
  // The tool's pose in the frame of the programs.
  Pose pose() const;
  // Number of calls of apply() since begin() or the last run().
  int line() const { return line_; }
  // Index of the current program in MillSummary::programs. The lines of apply() count as a program.
  size_t program() const;
  // Cuts all pending moves, so that the model holds them. Otherwise moves are cut in batches.
  void settle();
  // Collisions of all moves so far. Calls settle().
  const std::vector<MillCollision>& collisions();
  // Results of all moves so far. Calls settle().
  MillSummary summary();

 private:
  struct State;
  MillSession(TriDexel& model, const MillOptions& options);
  void begin_line();
  Status execute(const GcodeLine& line, const std::optional<AxisPosition>& from);
  Error at_line(const std::string& why) const;
  std::unique_ptr<State> state_;
  int line_ = 0;
};

}  // namespace kibori
