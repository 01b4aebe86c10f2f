// SPDX-License-Identifier: MIT
// Every tick of a document as researchers record them: poses of hand and tool, force and moment
// computed and given, what was removed of which material. As CSV, MCAP or HDF5; docs/recordings.md
// has the columns.
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
  int hand = 1;       // 2: the second one
  Mode mode = Mode::off;
  // In the world, wherever the body stood.
  Pose tool, hand_pose;  // [mm]
  Wrench computed;       // by the stroke's own force model [N, N mm]
  Wrench given;          // what the device was given, where that was kept; else NaN
  double removed_mm3 = 0;
  std::vector<double> removed_of;  // of each material of the recording [mm^3], by cuts and deposits
  int64_t points = 0;              // lattice nodes
};

// What a recording is of: all that its readers need to know of it, as JSON (program, version,
// document, lattice, materials, units, clock, steps with their settings and device).
struct TickRecords {
  std::string about;
  std::vector<std::string> materials;  // of removed_of, all that any stroke names
};

// Carves what leads to a step again, and calls use() with each tick. Errors: those of replaying, of
// use().
Result<TickRecords> about_ticks(const Document& document, StepId to);
Status for_tick_records(const Document& document, StepId to, const TickRecords& records,
                        const std::function<Status(const TickRecord&)>& use);

// The same into a file. Errors: those of the file, which is whole or not there.
Status write_ticks_csv(const std::filesystem::path& path, const Document& document, StepId to);
Status write_ticks_mcap(const std::filesystem::path& path, const Document& document, StepId to);
Status write_ticks_hdf5(const std::filesystem::path& path, const Document& document, StepId to);

}  // namespace kibori
