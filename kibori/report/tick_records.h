// SPDX-License-Identifier: MIT
// Records of every tick of a document, for research: poses of hand and tool, computed and given
// force and moment, removed volume per material. Formats are CSV, MCAP and HDF5. docs/recordings.md
// describes the columns.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/document/document.h>

namespace kibori {

// One tick of one hand.
struct TickRecord {
  StepId step = 0;
  double time_s = 0;  // since the recording's first tick; strokes follow one another
  int hand = 1;       // 2: the second hand
  Mode mode = Mode::off;
  // Poses and wrenches are in the world's coordinates.
  Pose tool, hand_pose;  // [mm]
  Wrench computed;       // by the stroke's own force model [N, N mm]
  Wrench given;          // sent to the device, if the document has it; otherwise NaN
  double removed_mm3 = 0;
  // For each material of the recording: volume that cuts removed; deposits are negative [mm^3].
  std::vector<double> removed_of;
  int64_t points = 0;  // number of lattice nodes that changed
  int line = 0;        // line of the milling program; 0: none
};

// Metadata of a recording. `about` is JSON with everything that readers need: program, version,
// document, lattice, materials, units, clock, and the steps with their settings and device.
struct TickRecords {
  std::string about;
  std::vector<std::string> materials;  // of removed_of: all materials of all strokes
  bool milled = false;                 // a milling program moved the tool in at least one stroke
};

// Collects the metadata of the steps that lead to `to`. Errors: a damaged document.
Result<TickRecords> about_ticks(const Document& document, StepId to);
// Replays these steps, and calls use() with each tick. Errors: those of the replay and of use().
Status for_tick_records(const Document& document, StepId to, const TickRecords& records,
                        const std::function<Status(const TickRecord&)>& use);

// Writes the ticks into a file. Errors: those of the file. The file is complete or does not exist.
Status write_ticks_csv(const std::filesystem::path& path, const Document& document, StepId to);
Status write_ticks_mcap(const std::filesystem::path& path, const Document& document, StepId to);
Status write_ticks_hdf5(const std::filesystem::path& path, const Document& document, StepId to);

}  // namespace kibori
