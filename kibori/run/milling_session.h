// SPDX-License-Identifier: MIT
// Mills line by line, for callers that compute each line themselves, and for simulators of CAM
// programs. (run_milling in milling.h runs whole files.) The resulting model is the same.
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
  // Starts a session. `model` and the objects to which `options` points must outlive it. Errors:
  // MillOptions::tool is not in the table.
  static Result<std::unique_ptr<MillSession>> begin(TriDexel& model, const MillOptions& options);
  ~MillSession();

  // Adds a tool, or replaces the tool with the same number. Puts the tool into the spindle. Errors:
  // its number is not 1 to 99999; those of check_tool.
  Status set_tool(const MillTool& tool);
  // Executes one line of G-code. `from` is the position of the machine before the line; nullopt:
  // the last position. Modes stay until a later line changes them. Errors: the line is invalid or
  // cannot be milled; the message has its number. After an error, the moves of the line before the
  // error are cut, but the modes are those before the line.
  Status apply(std::string_view line, const std::optional<AxisPosition>& from = std::nullopt);
  Status apply(const GcodeLine& line, const std::optional<AxisPosition>& from = std::nullopt);
  // Runs a program file. It begins with the default modes of the controller.
  Status run(const std::filesystem::path& program);

  // Returns the positions of the machine's axes after the last move, in the part's frame.
  const AxisPosition& at() const;
  // Returns the pose of the tool in the frame of the programs.
  Pose pose() const;
  // Returns the number of calls of apply() since begin(), or since the last run().
  int line() const { return line_; }
  // Returns the index of the current program in MillSummary::programs. The lines of apply() count
  // as one program.
  size_t program() const;
  // Cuts all pending moves, so that the model has them. Without this call, moves are cut in
  // batches.
  void settle();
  // Returns the collisions of all moves so far. Calls settle().
  const std::vector<MillCollision>& collisions();
  // Returns the results of all moves so far. Calls settle().
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
