// SPDX-License-Identifier: MIT
// Results of milling as text, JSON and CSV.
#pragma once

#include <string>
#include <vector>

#include <kibori/run/milling.h>
#include <kibori/run/milling_feeds.h>
#include <kibori/run/milling_plan.h>
#include <kibori/run/milling_target.h>

namespace kibori {

// For people. Lists at most ten collisions and ten gouges, and how many more there are. `target`:
// null if there is none.
std::string mill_text(const MillSummary& summary, const TargetReport* target = nullptr);
// The whole summary as JSON.
std::string mill_json(const MillSummary& summary, const TargetReport* target = nullptr);
// The result of a set-up of a job. `name`: empty if there is no job file.
struct MillResult {
  std::string name;
  const MillSummary* summary = nullptr;
  const TargetReport* target = nullptr;
  const FeedReport* feeds = nullptr;  // null: no feed limits were given
};
// The results of all set-ups. They contain pointers into the plan.
std::vector<MillResult> results_of(const MillPlan& plan);
// `results`: one result without a name, or all set-ups of a job. The text of a job has one set-up
// after another. Its JSON has the list "setups" and the hash of the last state.
std::string mill_text(const std::vector<MillResult>& results);
std::string mill_json(const std::vector<MillResult>& results);
// Columns: program,line,tool,path_mm,seconds,removed_mm3,section_mm2,depth_mm,width_mm,
// feed_per_tooth_mm,chip_mm,removal_mm3_s,resistance_n_mm2,force_n,power_w. Numbers of engagement
// and force are 0 if they are unknown.
std::string mill_lines_header();
std::string mill_line_csv(const MillLine& line);
// One sentence about a collision or a gouge, with file and line.
std::string collision_text(const MillSummary& summary, const MillCollision& collision);
std::string gouge_text(const MillSummary& summary, const DeepGouge& gouge);

}  // namespace kibori
