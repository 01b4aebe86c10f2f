// SPDX-License-Identifier: MIT
// Reports of the forces of a carving: a CSV file with every tick, an SVG plot, and a JSON summary.
#pragma once

#include <string>
#include <vector>

#include <kibori/run/carving_result.h>

namespace kibori {

// Returns the marks of a plot: the labels of the path. Between two places labelled by single
// letters A and B, adds the times of the first and last force, as A' and B'.
std::vector<Mark> contact_marks(const Carving& carving);

// Columns: time_s,x_mm,y_mm,z_mm,ax,ay,az,removed_mm3,points,fx_N,fy_N,fz_N,mx_Nmm,my_Nmm,mz_Nmm.
// One row per tick. With a second hand: one row per tick and hand, and the column `hand`.
std::string forces_csv(const Carving& carving);
// Descriptions of a force model: a few words for a title, and a sentence to put below a plot.
std::string model_title(const ForceLaw& law);
const char* model_note(ForceModel model);
// Plots |F|, |M| and their components over time, with marks on the axis and a note below. The scale
// fits most ticks. Spikes are cut off at the edge of a panel, and marked there with their values.
std::string forces_svg(const Carving& carving, const std::string& title, const std::string& note);
std::string summary_json(const CarveSummary& summary);
// For people.
std::string summary_text(const CarveSummary& summary);

}  // namespace kibori
