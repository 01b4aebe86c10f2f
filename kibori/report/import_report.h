// SPDX-License-Identifier: MIT
// Examines a file that a user wants to carve: its size, its up direction, its defects and its
// labels.
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

// If the size of a mesh is implausible, the mesh is scaled so that its longest side has this length
// [mm].
inline constexpr double kUsualLongestMm = 80;

// The assumed unit and size of a file, with the reason.
struct SizeGuess {
  // The unit of the numbers in the file: "mm" or "m". It is "fit" if the size is implausible. Then
  // the mesh is scaled to kUsualLongestMm.
  std::string unit;
  double longest_mm = 0;
  std::string why;  // a sentence
};
// `ending` is that of the file, with its dot. `longest_mm` is the longest side of the mesh that
// read_mesh returned.
SizeGuess guess_size(const std::string& ending, double longest_mm);

// The assumed up direction of a file, with the reason.
struct UpGuess {
  Orientation orientation;  // orientation of the mesh that read_mesh returned
  std::string why;          // a sentence
};
// Returns the usual up axis of the format (y or z). Returns the other axis if the mesh stands
// better with that axis up: see MeshFormat::Up.
UpGuess guess_up(const std::string& ending, const TriangleMesh& mesh);

// A label of a volume.
struct LabelReport {
  uint16_t label = 0;
  std::string name;       // "label 3" if the file does not name it
  double volume_mm3 = 0;  // volume of its voxels
  // Index in known_materials(): the material with the name of the label. If there is none, the
  // index depends on the position in the list, so that labels look different.
  uint8_t material = 0;
};

// The properties of a file before its import.
struct ImportReport {
  enum class Kind { mesh, relief, volume } kind = Kind::mesh;
  size_t triangles = 0;
  Vec3 size_mm = Vec3::Zero();  // mesh: bounds as read; volume: its grid; relief: unused
  double area_mm2 = 0;
  double unit_mm = 1;  // mm per unit that read_mesh assumed for the file
  SizeGuess size;
  UpGuess up;
  std::vector<std::string> repairs;  // one sentence each; empty: no repair is needed
  TriangleMesh preview;              // at most 30 000 triangles; empty for a relief
  GreyMap picture;                   // relief: for display, at most 160 pixels per side
  int width = 0, height = 0;         // relief: size of the picture in pixels
  std::vector<LabelReport> labels;   // volume: its labels
  // volume: for each vertex of the preview, the index of its label in `labels`.
  std::vector<uint32_t> kinds;
};

// Reads and examines a mesh, a picture or a labelled volume. Errors: those of read_mesh,
// read_png_grey and read_volume; the mesh has no extent; the volume has no material.
Result<ImportReport> report_import(const std::filesystem::path& path);

// Returns the report as JSON, without the preview.
std::string import_report_json(const ImportReport& report);
// Returns the preview or the picture as binary data for the page, little-endian:
//   mesh, volume:
//     number of vertices, number of triangles (u32)
//     coordinates (f32): the longest side is 1, the origin is the lower corner of the bounds
//     corners (u32)
//     volume only: index of the label of each vertex (u32, from 0)
//   picture:
//     width, height (u32)
//     pixels from the top (f32, 0 to 1)
std::vector<uint8_t> import_preview(const ImportReport& report);

}  // namespace kibori
