// SPDX-License-Identifier: MIT
// The list of mesh file formats. The command line, the studio, its page and the Python module use
// this list. CONTRIBUTING.md explains what else a new format needs.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace kibori {

// One format of mesh files.
struct MeshFormat {
  // The axis that points up in most files of the format. `turned`: always y; the reader turns y to
  // z. `mostly_z`: z, unless the mesh has a much larger flat base with y up. `mostly_y`: the same
  // with y and z exchanged. `perhaps_z`: like mostly_z; but a mesh without a flat base with z up
  // has y up if its centre of mass is then lower.
  enum class Up { turned, mostly_y, mostly_z, perhaps_z };

  std::string_view ending;  // in lower case, as ending_of() returns it
  bool written;             // true if write_surface supports it
  double unit_mm;           // mm per unit of the file; 1 if the file states its own unit
  const char* unit_note;    // a sentence for users, without the full stop
  Up up;
};

inline constexpr MeshFormat kMeshFormats[] = {
    {".stl", true, 1, "Files of this type are mostly in mm", MeshFormat::Up::mostly_z},
    {".ply", true, 1, "Files of this type are mostly in mm", MeshFormat::Up::perhaps_z},
    {".obj", true, 1, "Files of this type are mostly in mm", MeshFormat::Up::mostly_y},
    {".off", false, 1, "Files of this type are mostly in mm", MeshFormat::Up::perhaps_z},
    {".3mf", true, 1, "The file states its unit", MeshFormat::Up::mostly_z},
    {".glb", true, 1000, "GLB files are in metres", MeshFormat::Up::turned},
    {".gltf", false, 1000, "glTF files are in metres", MeshFormat::Up::turned},
};

// Returns the format with this ending, or null.
constexpr const MeshFormat* mesh_format_of(std::string_view ending) {
  for (const MeshFormat& format : kMeshFormats)
    if (format.ending == ending) return &format;
  return nullptr;
}

namespace internal {
// Returns the endings of all formats, or only of those that Kibori writes.
template <size_t N>
constexpr std::array<std::string_view, N> endings_of(bool written_only) {
  std::array<std::string_view, N> endings;
  size_t count = 0;
  for (const MeshFormat& format : kMeshFormats)
    if (format.written || !written_only) endings[count++] = format.ending;
  return endings;
}
}  // namespace internal

// The endings that read_mesh accepts, and those that write_surface accepts.
inline constexpr auto kMeshesRead = internal::endings_of<std::size(kMeshFormats)>(false);
inline constexpr auto kMeshesWritten = internal::endings_of<static_cast<size_t>(
    std::count_if(std::begin(kMeshFormats), std::end(kMeshFormats),
                  [](const MeshFormat& format) { return format.written; }))>(true);

// Returns true if `ending` is in the list.
constexpr bool is_one_of(const auto& endings, std::string_view ending) {
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

// Returns the endings as one text. For example, `between` = ", " and `last` = " and " give ".stl,
// .ply and .glb". If `last` is empty, `between` is used instead.
std::string list_of(const auto& endings, std::string_view between = ", ",
                    std::string_view last = {}) {
  std::string text;
  for (const std::string_view& ending : endings) {
    if (!text.empty()) text += &ending == &endings.back() && !last.empty() ? last : between;
    text += ending;
  }
  return text;
}

}  // namespace kibori
