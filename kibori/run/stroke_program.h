// SPDX-License-Identifier: MIT
// Converts the strokes of a document into G-code for a milling machine with three axes.
//
//   Document ─► stroke_paths ─► lines of G-code ─► MillSession on a copy of the model
//                                                     │ compared with a replay of the stroke
//                                                     ▼
//                                               kept, or listed with the reason
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/document/document.h>
#include <kibori/mill/tool_table.h>

namespace kibori {

struct StrokeProgramOptions {
  StepId first = 0, last = 0;  // steps on the path to the head; 0: its first and its last one
  double clearance_mm = 5;     // height of rapid moves above the stock
  double feed_mm_min = 1000;
  double rpm = 12000;
  int teeth = 2;  // number of teeth of every tool
  int threads = 1;
};

// A stroke that the machine cannot make. `reason` is the end of a sentence about the stroke.
struct UnreachedStroke {
  StepId step = 0;
  std::string label, reason;
};

struct StrokeProgram {
  std::string text;  // G-code in mm, in the coordinates of the model
  ToolTable tools;
  int64_t strokes = 0;  // number of strokes in the program
  std::vector<UnreachedStroke> unreached;
  std::unique_ptr<TriDexel> stock, result;  // models before and after the program
  // Volume after the program, minus volume after the last step in the document [mm^3]. Positive:
  // the program lacks strokes. Negative: the program removes more than the strokes.
  double left_over_mm3 = 0;
};

// Makes a program of the strokes. Errors: a step is not on the path to the head; the document has
// several bodies, or a locked or protected one; a machine can make none of the strokes; those of
// the document.
Result<StrokeProgram> program_of_strokes(const Document& document,
                                         const StrokeProgramOptions& options);

// Returns the tool table as TOML, for kibori mill.
std::string tools_toml(const ToolTable& table);

}  // namespace kibori
