// SPDX-License-Identifier: MIT
// Scenes that consist of a stock only, to carve by hand. Materials are indices of
// known_materials().
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <kibori/base/result.h>
#include <kibori/scene/scene.h>

namespace kibori {

// Max number of rays along a stock's longest side that a page can show.
inline constexpr double kMaxRays = 1024;

// Makes a scene of a stock that is not from a file. Errors: the size, pitch or material is not
// valid.
Result<Scene> stock_scene(const StockShape& shape, double pitch_mm, size_t material);

// The options that make a stock from a file.
struct FileStock {
  // Scales the file so that its longest side has this length. For a picture, the height of the
  // relief does not count. A volume is not scaled. For it, this length and `rays` set the pitch.
  double longest_mm = 0;
  double rays = 0;  // along that side
  size_t material = 0;
  Orientation orientation = {};             // mesh
  double height_mm = 5, base_mm = 5;        // picture
  bool invert = false;                      // picture
  std::map<uint16_t, uint8_t> labels = {};  // volume: the material of each
};

// Makes a scene of a stock from a mesh, a labelled volume, or a picture (PNG) as a relief. Errors:
// the file cannot be read, or those of stock_scene().
Result<Scene> file_scene(const std::filesystem::path& file, const FileStock& how);

// A mesh that becomes a body, as a tool whose tip is the centre of its bounds. Uses only size and
// orientation of `how`. Errors: the file cannot be read or is a picture, or the size is not valid.
Result<Tool> file_shape(const std::filesystem::path& file, const FileStock& how);

}  // namespace kibori
