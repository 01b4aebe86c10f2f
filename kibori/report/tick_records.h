// SPDX-License-Identifier: MIT
// Records all ticks of a document, for research: the poses of hand and tool, the computed and the
// given force and moment, and the removed volume of each material. The formats are CSV, MCAP and
// HDF5. docs/recordings.md describes the columns.
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
  double time_s = 0;  // since the first tick of the recording; there are no gaps between strokes
  int hand = 1;       // 2: the second hand
  Mode mode = Mode::off;
  // Poses and wrenches are in the world's coordinates.
  Pose tool, hand_pose;  // [mm]
  Wrench computed;       // by the stroke's own force model [N, N mm]
  Wrench given;          // sent to the device; NaN if the document does not have it
  double removed_mm3 = 0;
  // For each material of the recording: the volume that cuts removed [mm^3]. Deposits are negative.
  std::vector<double> removed_of;
  int64_t points = 0;  // number of lattice nodes that changed
  int line = 0;        // line of the milling program; 0: none
};

// The metadata of a recording. `about` is JSON with all that readers need: program, version,
// document, lattice, materials, units, clock, and the steps with their settings and device.
struct TickRecords {
  std::string about;
  std::vector<std::string> materials;  // materials of removed_of: those of all strokes
  bool milled = false;                 // true if a milling program moved the tool in a stroke
};

// Returns the metadata of the steps on the path to `to`. Errors: the document is damaged.
Result<TickRecords> about_ticks(const Document& document, StepId to);
// Replays these steps, and calls use() with each tick. Errors: those of the replay and of use().
Status for_tick_records(const Document& document, StepId to, const TickRecords& records,
                        const std::function<Status(const TickRecord&)>& use);

// Write the ticks of these steps into a file, completely or not at all. Errors: those of the
// replay; the file cannot be written.
Status write_ticks_csv(const std::filesystem::path& path, const Document& document, StepId to);
Status write_ticks_mcap(const std::filesystem::path& path, const Document& document, StepId to);
Status write_ticks_hdf5(const std::filesystem::path& path, const Document& document, StepId to);

}  // namespace kibori
