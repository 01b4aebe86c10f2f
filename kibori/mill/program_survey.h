// SPDX-License-Identifier: MIT
// What a program needs, before it is milled: the bounds of its path and the numbers of its tools.
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
  std::optional<Box> feed_mm;  // of the tip in feed moves; none: there is no feed move
  std::set<int> tools;         // that T names
  bool turns = false;          // it moves a rotary axis
  int64_t moves = 0;
};

// Reads a whole program. Errors: those of open_program and Program::next; the survey was stopped.
Result<ProgramSurvey> survey_program(const std::filesystem::path& path,
                                     const Rs274Limits& limits = {});

// A block for the programs, if nobody states one: around the path of the tip, wider by the cutter's
// radius. Its top is at z = 0 if the path goes below, as in most programs. Its lower face is a tenth
// of the depth below the path.
std::optional<Box> suggested_stock(const std::vector<ProgramSurvey>& surveys, double radius_mm);

}  // namespace kibori
