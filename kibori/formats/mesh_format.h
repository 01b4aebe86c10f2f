// SPDX-License-Identifier: MIT
// The formats of mesh files: one row each.
//
// A new format is a row here, a reader (read_mesh in mesh_file.cpp, or the program kibori-import in
// apps/import/main.cpp), a writer if it is written (surface_file.cpp), and a corpus and a fuzzer in
// fuzz/. Command line, studio and page take their lists from here.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace kibori {

struct MeshFormat {
  // Which axis of the file's points up. `turned`: always y, and the reader turns it. `perhaps_z`:
  // z, unless the mesh lies better with y up.
  enum class Up { turned, mostly_y, mostly_z, perhaps_z };

  std::string_view ending;  // lower case, as ending_of gives it
  bool written;             // by write_surface
  double unit_mm;           // one unit of the file, which the reader has made mm
  const char* unit_note;    // for people, without its full stop
  Up up;
};

inline constexpr MeshFormat kMeshFormats[] = {
    {".stl", true, 1, "Files like this one are mostly in mm", MeshFormat::Up::mostly_z},
    {".ply", true, 1, "Files like this one are mostly in mm", MeshFormat::Up::perhaps_z},
    {".obj", true, 1, "Files like this one are mostly in mm", MeshFormat::Up::mostly_y},
    {".off", false, 1, "Files like this one are mostly in mm", MeshFormat::Up::perhaps_z},
    {".3mf", true, 1, "The file says its unit", MeshFormat::Up::mostly_z},
    {".glb", true, 1000, "GLB files are in metres", MeshFormat::Up::turned},
};

// The format of an ending; null: none.
constexpr const MeshFormat* mesh_format_of(std::string_view ending) {
  for (const MeshFormat& format : kMeshFormats)
    if (format.ending == ending) return &format;
  return nullptr;
}

namespace internal {
// The endings of all formats, or of those that are written.
template <size_t N>
constexpr std::array<std::string_view, N> endings_of(bool written_only) {
  std::array<std::string_view, N> endings;
  size_t count = 0;
  for (const MeshFormat& format : kMeshFormats)
    if (format.written || !written_only) endings[count++] = format.ending;
  return endings;
}
}  // namespace internal

// What read_mesh reads, and what write_surface writes.
inline constexpr auto kMeshesRead = internal::endings_of<std::size(kMeshFormats)>(false);
inline constexpr auto kMeshesWritten = internal::endings_of<static_cast<size_t>(
    std::count_if(std::begin(kMeshFormats), std::end(kMeshFormats),
                  [](const MeshFormat& format) { return format.written; }))>(true);

constexpr bool is_one_of(const auto& endings, std::string_view ending) {
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

// ".stl, .ply and .glb" by ", " and " and "; `last` is as `between` where it is left out.
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
