// SPDX-License-Identifier: MIT
// The report of `kibori info` on a mesh file, or on the surface of a document.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh_info.h>

namespace kibori {

// Walls whose two faces are opposite and nearer to each other than `threshold_mm`. The distance is
// measured along the three directions of dexels.
struct ThinWalls {
  double threshold_mm, pitch_mm;  // walls thinner than the pitch may be missed
  double thinnest_mm;             // infinite if there are no opposite faces
  Vec3 at_mm;                     // position of the thinnest wall
  double share;                   // share of the area of walls that is thinner than the threshold
};

// Faces for which a printer that builds upwards along z needs supports. They face down, and lean
// from the vertical by more than `threshold_deg`. Faces on the bed (the minimum height) do not
// count.
struct Overhangs {
  double threshold_deg;
  double area_mm2 = 0;
  double share = 0;  // share of the whole surface
};

// The properties of a mesh file.
struct MeshReport {
  MeshInfo info;
  Overhangs overhangs{};
  std::optional<ThinWalls> walls;
  std::string no_walls;            // reason why `walls` is empty
  std::vector<std::string> notes;  // sentences about parts of the file that were left out
};

struct MeshReportOptions {
  double wall_mm = 1;
  double overhang_deg = 45;
  // Pitch of the dexels in the search for thin walls. Default: the longest side divided by 256.
  std::optional<double> pitch_mm;
  int threads = 1;
};

// Reads and examines a file. Errors: those of read_mesh_or_document.
Result<MeshReport> report_mesh(const std::filesystem::path& path, const MeshReportOptions& options);

// Return the report as text for people, and as JSON.
std::string mesh_report_text(const MeshReport& report);
std::string mesh_report_json(const MeshReport& report);

}  // namespace kibori
