// SPDX-License-Identifier: MIT
// The results of milling as text, JSON and CSV.
#pragma once

#include <string>
#include <vector>

#include <kibori/run/milling.h>
#include <kibori/run/milling_feeds.h>
#include <kibori/run/milling_plan.h>
#include <kibori/run/milling_target.h>

namespace kibori {

// Returns a text for people. It lists at most ten collisions and ten gouges, and says how many more
// there are. `target` is null if there is no target.
std::string mill_text(const MillSummary& summary, const TargetReport* target = nullptr);
// Returns the whole summary as JSON.
std::string mill_json(const MillSummary& summary, const TargetReport* target = nullptr);
// The result of one set-up of a milling job. `name` is empty if there is no job file.
struct MillResult {
  std::string name;
  const MillSummary* summary = nullptr;
  const TargetReport* target = nullptr;
  const FeedReport* feeds = nullptr;  // null if there are no feed limits
};
// Returns the results of all set-ups. They contain pointers into the plan.
std::vector<MillResult> results_of(const MillPlan& plan);
// `results` has one result without a name, or the results of all set-ups of a job. The text
// contains one set-up after another. The JSON of a job has the list "setups" and the hash of the
// last state.
std::string mill_text(const std::vector<MillResult>& results);
std::string mill_json(const std::vector<MillResult>& results);
// Return the header and one line of a CSV file. Columns: program,line,tool,path_mm,seconds,
// removed_mm3,section_mm2,depth_mm,width_mm,feed_per_tooth_mm,chip_mm,removal_mm3_s,
// resistance_n_mm2,force_n,power_w. The columns of engagement and force are 0 if unknown.
std::string mill_lines_header();
std::string mill_line_csv(const MillLine& line);
// Return one sentence about a collision or a gouge, with file and line.
std::string collision_text(const MillSummary& summary, const MillCollision& collision);
std::string gouge_text(const MillSummary& summary, const DeepGouge& gouge);

}  // namespace kibori
