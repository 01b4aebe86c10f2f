// SPDX-License-Identifier: MIT
// What a carving felt like, for people and programs: a CSV of every tick, an SVG plot, a JSON
// summary.
#pragma once

#include <string>
#include <vector>

#include <kibori/run/carving_result.h>

namespace kibori {

// The marks of a plot: the labels, and between two places labelled by a letter where the tool met
// the stock its first and last contact, as A' and B'.
std::vector<Mark> contact_marks(const Carving& carving);

// time_s,x_mm,y_mm,z_mm,ax,ay,az,removed_mm3,points,fx_N,fy_N,fz_N,mx_Nmm,my_Nmm,mz_Nmm; one row a
// tick.
std::string forces_csv(const Carving& carving);
// What a force model is: a few words for a title, and a sentence for under a plot.
std::string model_title(const ForceLaw& law);
const char* model_note(ForceModel model);
// |F|, |M| and their components over time, the marks on the axis, a note below. The scale is that
// of most ticks: spikes are cut off where a panel ends, and marked there with their sizes.
std::string forces_svg(const Carving& carving, const std::string& title, const std::string& note);
std::string summary_json(const CarveSummary& summary);
// For people.
std::string summary_text(const CarveSummary& summary);

}  // namespace kibori
