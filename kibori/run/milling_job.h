// SPDX-License-Identifier: MIT
// Job files of milling. A job has one stock, and set-ups that mill it one after another.
//
//   stock = [0, 0, -20, 80, 60, 0]
//   tools = "tools.toml"
//   [[setup]]
//   programs = ["top.nc"]
//   [[setup]]                  # the same part, turned over
//   turn = [180, 0, 0]
//   shift = [0, 60, -20]
//   programs = ["bottom.nc"]
//
// The model keeps the coordinates of the stock in all set-ups. A set-up gives the motion of the
// part since the set-up before it: first `turn` [degrees], then `shift` [mm]. From this follows the
// frame of its programs in the model.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>
#include <kibori/run/milling.h>

namespace kibori {

struct MillJobSetup {
  std::string name;  // "1", "2", ... if the file gives none
  Pose frame;        // of its programs, in the model
  std::vector<std::filesystem::path> programs;
  std::filesystem::path tools, machine, target;  // empty: none
  std::vector<std::filesystem::path> fixtures;   // in the programs' coordinates, like `target`
  std::optional<int> tool;                       // in the spindle at the start
};

struct MillJob {
  MillStock stock;
  std::optional<double> pitch_mm, tolerance_mm;
  std::optional<std::string> material;
  std::vector<MillJobSetup> setups;  // at least one
};

// Parses a job file. File names are relative to `folder`. `name`: for messages. Errors: one
// sentence with file, line and key.
Result<MillJob> parse_mill_job(const std::string& text, const std::string& name,
                               const std::filesystem::path& folder);
Result<MillJob> read_mill_job(const std::filesystem::path& path);

}  // namespace kibori
