// SPDX-License-Identifier: MIT
// Job files of milling. A job has one stock, and set-ups that mill it in order. A set-up is one
// position of the part, with its programs.
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
// The model keeps the coordinates of the stock in all set-ups. A set-up states how the part has
// moved since the set-up before: first `turn` [degrees], then `shift` [mm]. The frame of its
// programs in the model follows from these motions.
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
  std::string name;  // "1", "2", ... if the file does not name it
  Pose frame;        // frame of the programs in the model
  std::vector<std::filesystem::path> programs;
  std::filesystem::path tools, machine, target;  // empty: none
  std::vector<std::filesystem::path> fixtures;   // in program coordinates, like `target`
  std::optional<int> tool;                       // tool in the spindle at the start
};

struct MillJob {
  MillStock stock;
  std::optional<double> pitch_mm, tolerance_mm;
  std::optional<std::string> material;
  std::vector<MillJobSetup> setups;  // at least one
};

// Parse or read a job file. `name` is its name in messages. File names are relative to `folder` (or
// to the folder of `path`). Errors: the file cannot be read or a value is invalid. The message has
// file, line and key.
Result<MillJob> parse_mill_job(const std::string& text, const std::string& name,
                               const std::filesystem::path& folder);
Result<MillJob> read_mill_job(const std::filesystem::path& path);

}  // namespace kibori
