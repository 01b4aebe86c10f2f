// SPDX-License-Identifier: MIT
// What a program needs: the bounds of its path, and the numbers of its tools. The survey does not
// mill.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>
#include <kibori/mill/rs274.h>

namespace kibori {

struct ProgramSurvey {
  std::optional<Box> feed_mm;  // bounds of the tip in feed moves; none: there is no feed move
  std::set<int> tools;         // numbers of the tools that the program names
  bool turns = false;          // true if the program moves a rotary axis
  int64_t moves = 0;
};

// Reads a whole program. Errors: those of open_program and Program::next; limits.stop stopped the
// survey.
Result<ProgramSurvey> survey_program(const std::filesystem::path& path,
                                     const Rs274Limits& limits = {});

// Returns a block for the programs, for users who do not give a stock. The block contains the path
// of the tip, and is wider by the cutter's radius. If the path goes below z = 0, the top of the
// block is z = 0. The lower face is below the path by a tenth of the block's depth. Returns nullopt
// if there is no feed move.
std::optional<Box> suggested_stock(const std::vector<ProgramSurvey>& surveys, double radius_mm);

}  // namespace kibori
