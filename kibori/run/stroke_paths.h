// SPDX-License-Identifier: MIT
// Converts the strokes of a document to paths of a milling cutter on a machine with three axes.
#pragma once

#include <vector>

#include <kibori/base/result.h>
#include <kibori/document/document.h>
#include <kibori/geometry/vec.h>
#include <kibori/solid/tool.h>

namespace kibori {

// The points that the tip visits without lifting [mm], at least two. If the tool cuts without
// moving, all are equal.
using StrokePath = std::vector<Vec3>;

struct StrokePaths {
  Tool tool;
  std::vector<StrokePath> paths;  // including the images of a symmetric stroke
};

// The paths of a stroke. Points that are within `tolerance_mm` of a straight path are left out.
// Errors: those of the document, or the reason why a milling machine cannot follow the stroke.
// Reasons are a mode other than cut, a tool that is not round, a tilted tool, and two hands. The
// text continues a sentence whose subject is the stroke: "uses ...", "tilts ...".
Result<StrokePaths> stroke_paths(const Document& document, StepId step, double tolerance_mm);

// True if the stroke leaves the model unchanged: its modes are touch or off.
bool changes_nothing(const StrokeSettings& settings);

// True if the tool is a solid of revolution about its axis and has the shape of a milling cutter.
bool is_round_cutter(const Tool& tool);
// The same cutter with a shaft that reaches at least `height_mm` above its tip.
Tool with_long_shaft(const Tool& tool, double height_mm);

}  // namespace kibori
