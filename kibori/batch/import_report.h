// SPDX-License-Identifier: MIT
// What a file that someone wants to carve seems to be: how large, which way up, and what must be
// repaired.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/formats/png_file.h>
#include <kibori/geometry/mesh.h>
#include <kibori/geometry/orientation.h>

namespace kibori {

// A mesh of an implausible size is scaled to this length [mm].
inline constexpr double kUsualLongestMm = 80;

struct SizeGuess {
  std::string unit;  // of the file's numbers: "mm" or "m"; "fit": can't be meant, so it is scaled
  double longest_mm = 0;
  std::string why;  // a sentence
};
// `ending`: of the file, with its dot; `longest_mm`: of its bounds as read_mesh gives them.
SizeGuess guess_size(const std::string& ending, double longest_mm);

struct UpGuess {
  Orientation orientation;  // of the mesh as read_mesh gives it
  std::string why;          // a sentence
};
// The format's usual up axis, or the other one if only that gives a flat base.
UpGuess guess_up(const std::string& ending, const TriangleMesh& mesh);

struct ImportReport {
  bool relief = false;  // a picture; then only the picture below is filled in
  size_t triangles = 0;
  Vec3 size_mm = Vec3::Zero();  // of the bounds, as read
  double area_mm2 = 0;
  double unit_mm = 1;  // what read_mesh took the file's unit for
  SizeGuess size;
  UpGuess up;
  std::vector<std::string> repairs;  // sentences; none: nothing is to be repaired
  TriangleMesh preview;              // at most 30 000 triangles
  GreyMap picture;                   // as it is shown: at most 160 pixels a side
  int width = 0, height = 0;         // of the picture in the file
};

// Reads a mesh or a picture. Errors: those of read_mesh and read_png_grey, a mesh without extent.
Result<ImportReport> report_import(const std::filesystem::path& path);

std::string import_report_json(const ImportReport& report);
// Little-endian. Mesh: counts of vertices and triangles (u32), coordinates (f32; the longest side
// is 1, the lower corner of the bounds the origin), corners (u32). Picture: width, height (u32),
// pixels from the top (f32, 0 to 1).
std::vector<uint8_t> import_preview(const ImportReport& report);

}  // namespace kibori
