// SPDX-License-Identifier: MIT
// Endings of the files that hold meshes, lower case, as base/file.h's ending_of gives them.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

namespace kibori {

// What read_mesh reads, and what write_surface writes.
inline constexpr std::array<std::string_view, 6> kMeshesRead{".stl", ".ply", ".obj",
                                                             ".off", ".3mf", ".glb"};
inline constexpr std::array<std::string_view, 5> kMeshesWritten{".stl", ".ply", ".obj", ".3mf",
                                                                ".glb"};

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
