// SPDX-License-Identifier: MIT
// Results of milling as text, JSON and CSV.
#pragma once

#include <string>

#include <kibori/run/milling.h>
#include <kibori/run/milling_target.h>

namespace kibori {

// For people. Lists at most ten collisions and ten gouges, and how many more there are. `target`:
// null if there is none.
std::string mill_text(const MillSummary& summary, const TargetReport* target = nullptr);
// Everything in the summary.
std::string mill_json(const MillSummary& summary, const TargetReport* target = nullptr);
// Columns: program,line,tool,path_mm,seconds,removed_mm3,section_mm2,depth_mm,width_mm,
// feed_per_tooth_mm,chip_mm,removal_mm3_s,resistance_n_mm2,force_n,power_w. Numbers of engagement
// and force are 0 if they are unknown.
std::string mill_lines_header();
std::string mill_line_csv(const MillLine& line);
// One sentence about a collision, with file and line.
std::string collision_text(const MillSummary& summary, const MillCollision& collision);
std::string gouge_text(const MillSummary& summary, const DeepGouge& gouge);

}  // namespace kibori
