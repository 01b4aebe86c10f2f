// SPDX-License-Identifier: MIT
// Reports on the forces of a carving: a CSV file with all ticks, an SVG plot, and a summary.
#pragma once

#include <string>
#include <vector>

#include <kibori/run/carving_result.h>

namespace kibori {

// Returns the marks for a plot: the labels of the path. Between two neighbouring labels that are
// single letters A and B, also marks the first force as A' and the last force as B'.
std::vector<Mark> contact_marks(const Carving& carving);

// Returns a CSV file. Columns:
// time_s,x_mm,y_mm,z_mm,ax,ay,az,removed_mm3,points,fx_N,fy_N,fz_N,mx_Nmm,my_Nmm,mz_Nmm. Each tick
// has one row. With a second hand, each tick has one row per hand, and there is the column `hand`.
std::string forces_csv(const Carving& carving);
// Return descriptions of a force model: a few words for a title, and a sentence to put below a
// plot.
std::string model_title(const ForceLaw& law);
const char* model_note(ForceModel model);
// Returns an SVG plot of |F|, |M| and their components over time, with marks and a note. The scale
// fits nearly all ticks. Larger values are cut off at the edge of a panel, and marked there with
// their numbers.
std::string forces_svg(const Carving& carving, const std::string& title, const std::string& note);
// Returns the summary as JSON.
std::string summary_json(const CarveSummary& summary);
// Returns the summary as text for people.
std::string summary_text(const CarveSummary& summary);

}  // namespace kibori
