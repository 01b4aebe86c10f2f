// SPDX-License-Identifier: MIT
// The report of `kibori info` on a mesh file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh_info.h>

namespace kibori {

// Walls where opposite faces are nearer to each other than `threshold_mm`, measured along the three
// directions of dexels.
struct ThinWalls {
  double threshold_mm, pitch_mm;  // walls thinner than the pitch may be missed
  double thinnest_mm;             // infinite if no two faces are opposite
  Vec3 at_mm;                     // position of the thinnest wall
  double share;                   // share of the walls' area that is thinner than the threshold
};

// Faces that a printer would have to print without support, if it builds upward along z. They face
// down and lean from the vertical by more than `threshold_deg`. Faces on the bed (the minimum
// height) do not count.
struct Overhangs {
  double threshold_deg;
  double area_mm2 = 0;
  double share = 0;  // of the whole surface
};

// The properties of a mesh file.
struct MeshReport {
  MeshInfo info;
  Overhangs overhangs{};
  std::optional<ThinWalls> walls;
  std::string no_walls;            // the reason why `walls` is empty
  std::vector<std::string> notes;  // parts of the file that were left out, a sentence each
};

struct MeshReportOptions {
  double wall_mm = 1;
  double overhang_deg = 45;
  // Pitch of the dexels for the search of thin walls. Default: the longest side divided by 256.
  std::optional<double> pitch_mm;
  int threads = 1;
};

// Errors: see read_mesh.
Result<MeshReport> report_mesh(const std::filesystem::path& path, const MeshReportOptions& options);

// The report for people, and as JSON.
std::string mesh_report_text(const MeshReport& report);
std::string mesh_report_json(const MeshReport& report);

}  // namespace kibori
