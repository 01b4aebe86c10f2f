// SPDX-License-Identifier: MIT
// Scenes that have only a stock, to carve by hand. Materials are indices of known_materials().
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <kibori/base/result.h>
#include <kibori/scene/scene.h>

namespace kibori {

// Maximum number of rays along the longest side of a stock that a page can show.
inline constexpr double kMaxRays = 1024;

// Makes a scene of a stock that is not from a file. Errors: the size, the pitch or the material is
// not valid.
Result<Scene> stock_scene(const StockShape& shape, double pitch_mm, size_t material);

// Options for a stock from a file.
struct FileStock {
  // Length of the longest side after scaling. For a picture, the height of the relief does not
  // count. A volume is not scaled; for a volume, this length and `rays` define the pitch.
  double longest_mm = 0;
  double rays = 0;  // number of rays along that side
  size_t material = 0;
  Orientation orientation = {};             // for meshes
  double height_mm = 5, base_mm = 5;        // for pictures
  bool invert = false;                      // for pictures
  std::map<uint16_t, uint8_t> labels = {};  // for volumes: the material of each label
};

// Makes a scene of a stock from a mesh, a labelled volume, or a picture (PNG) as a relief. Errors:
// the file cannot be read; those of stock_scene().
Result<Scene> file_scene(const std::filesystem::path& file, const FileStock& how);

// Makes a tool of a mesh that becomes a body. The tip of the tool is the centre of its bounds. Only
// the size and the orientation of `how` are used. Errors: the file cannot be read, or is a picture;
// the size is not valid.
Result<Tool> file_shape(const std::filesystem::path& file, const FileStock& how);

}  // namespace kibori
