// SPDX-License-Identifier: MIT
// What `kibori info` says of a mesh file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh_info.h>

namespace kibori {

// Where opposite faces come nearer to each other than `threshold_mm`, seen along the three
// directions of dexels.
struct ThinWalls {
  double threshold_mm, pitch_mm;  // walls thinner than the pitch may be missed
  double thinnest_mm;             // infinite where no two faces are opposite
  Vec3 at_mm;                     // a place where it is thinnest
  double share;                   // of the wall area (pairs of opposite faces) below the threshold
};

// Faces that a printer, which builds upward along z, has to put down in the air: they look down,
// and lean from upright by more than `threshold_deg`. What lies on the bed, the lowest height, is
// none.
struct Overhangs {
  double threshold_deg;
  double area_mm2 = 0;
  double share = 0;  // of the whole surface
};

struct MeshReport {
  MeshInfo info;
  Overhangs overhangs{};
  std::optional<ThinWalls> walls;
  std::string no_walls;  // why there are none
};

struct MeshReportOptions {
  double wall_mm = 1;
  double overhang_deg = 45;
  // Of the dexels that look for thin walls; default: the longest side by 256.
  std::optional<double> pitch_mm;
  int threads = 1;
};

// Errors: those of read_mesh.
Result<MeshReport> report_mesh(const std::filesystem::path& path, const MeshReportOptions& options);

std::string mesh_report_text(const MeshReport& report);
std::string mesh_report_json(const MeshReport& report);

}  // namespace kibori
