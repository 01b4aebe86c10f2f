// SPDX-License-Identifier: MIT
// What a file that someone wants to carve seems to be: how large, which way up, what must be
// repaired, and which labels it has.
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

// A label of a volume.
struct LabelReport {
  uint16_t label = 0;
  std::string name;       // "label 3", where the file has none
  double volume_mm3 = 0;  // of its voxels
  uint8_t material = 0;   // of known_materials(): one that is called so, or another for each
};

struct ImportReport {
  enum class Kind { mesh, relief, volume } kind = Kind::mesh;
  size_t triangles = 0;
  Vec3 size_mm = Vec3::Zero();  // of the bounds, as read; volume: of its grid; relief: none
  double area_mm2 = 0;
  double unit_mm = 1;  // what read_mesh took the file's unit for
  SizeGuess size;
  UpGuess up;
  std::vector<std::string> repairs;  // sentences; none: nothing is to be repaired
  TriangleMesh preview;              // at most 30 000 triangles; none of a relief
  GreyMap picture;                   // relief: as it is shown, at most 160 pixels a side
  int width = 0, height = 0;         // relief: of the picture in the file
  std::vector<LabelReport> labels;   // volume
  std::vector<uint32_t> kinds;       // volume: of each vertex of the preview, which of `labels`
};

// Reads a mesh, a picture or a labelled volume. Errors: those of read_mesh, read_png_grey and
// read_nrrd; a mesh without extent, a volume of air.
Result<ImportReport> report_import(const std::filesystem::path& path);

std::string import_report_json(const ImportReport& report);
// Little-endian. Mesh and volume: counts of vertices and triangles (u32), coordinates (f32; the
// longest side is 1, the lower corner of the bounds the origin), corners (u32), and of a volume
// which label each vertex is of (u32, from 0). Picture: width, height (u32), pixels from the top
// (f32, 0 to 1).
std::vector<uint8_t> import_preview(const ImportReport& report);

}  // namespace kibori
