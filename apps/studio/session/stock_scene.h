// SPDX-License-Identifier: MIT
// Scenes that are stock alone: what one begins with to carve by hand. Materials are numbers of
// known_materials().
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <kibori/base/result.h>
#include <kibori/scene/scene.h>

namespace kibori {

// So fine at most along a stock's longest side, so that a page can show it.
inline constexpr double kMaxRays = 1024;

// A shape that is no file. Errors: the size, the pitch, the material.
Result<Scene> stock_scene(const StockShape& shape, double pitch_mm, size_t material);

// How a file becomes a stock.
struct FileStock {
  // It is scaled so that its longest side is this; of a picture without its height. A volume is
  // not: it is what the rays are counted by.
  double longest_mm = 0;
  double rays = 0;  // along that side
  size_t material = 0;
  Orientation orientation = {};             // mesh
  double height_mm = 5, base_mm = 5;        // picture
  bool invert = false;                      // picture
  std::map<uint16_t, uint8_t> labels = {};  // volume: the material of each
};

// A mesh, a labelled volume or, as a relief, a picture (PNG). Errors: those of reading a picture,
// and as above.
Result<Scene> file_scene(const std::filesystem::path& file, const FileStock& how);

// A mesh that is to be a body, as a tool whose tip is in the middle of its bounds. Of `how`, its
// size and how it stands. Errors: those of reading it; a picture; the size.
Result<Tool> file_shape(const std::filesystem::path& file, const FileStock& how);

}  // namespace kibori
