// SPDX-License-Identifier: MIT
// Converts the strokes of a document into paths of a milling cutter, on a machine with three axes.
#pragma once

#include <vector>

#include <kibori/base/result.h>
#include <kibori/document/document.h>
#include <kibori/geometry/vec.h>
#include <kibori/solid/tool.h>

namespace kibori {

// The points that the tip visits without lifting [mm]: at least two. If the tool cuts without a
// motion, all points are equal.
using StrokePath = std::vector<Vec3>;

struct StrokePaths {
  Tool tool;
  std::vector<StrokePath> paths;  // with the paths of the images of a symmetric stroke
};

// Returns the paths of a stroke. Points within `tolerance_mm` of a straight path are left out.
// Errors: those of the document; a milling machine cannot follow the stroke. In the second case,
// the text is the end of a sentence about the stroke: "uses ...", "tilts ...". Reasons are: the
// mode is not cut; the tool is not round, or is tilted; there are two hands.
Result<StrokePaths> stroke_paths(const Document& document, StepId step, double tolerance_mm);

// Returns true if the stroke leaves the model unchanged, because its modes are touch or off.
bool changes_nothing(const StrokeSettings& settings);

// Returns true if the tool is a solid of revolution about its axis, in the shape of a milling
// cutter.
bool is_round_cutter(const Tool& tool);
// Returns the same cutter, with a shaft that reaches at least `height_mm` above the tip.
Tool with_long_shaft(const Tool& tool, double height_mm);

}  // namespace kibori
