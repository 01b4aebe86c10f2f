// SPDX-License-Identifier: MIT
// Writes a model without a mesh: as a height map, or as a stack of layers.
#pragma once

#include <filesystem>
#include <functional>

#include <kibori/base/result.h>
#include <kibori/surface/layers.h>

namespace kibori {

// Size and range of a height map.
struct HeightMapSummary {
  int width = 0, height = 0;
  double low_mm = 0, high_mm = 0;  // heights of grey 1 and 65535; grey 0 is no material
};
// Writes a 16-bit grey PNG with one pixel per ray. Errors: those of the file, or no material.
Result<HeightMapSummary> write_height_map(const std::filesystem::path& path, const Snapshot& model);

enum class LayerFormat { svg, png };

struct LayerOptions {
  double layer_mm = 0.2;  // distance between layers; layers closer than the pitch become one
  LayerFormat format = LayerFormat::svg;
  int threads = 1;
  std::function<void(double)> progress;
};
// Writes layer-0001.svg or .png and so on, from below, into `folder`. It creates the folder if
// necessary. SVG files are in mm, with one path and even-odd filling. PNG files are black and
// white, with one pixel per node. Returns the number of layers. Errors: a folder that is not
// writable, or no material.
Result<int> write_layers(const std::filesystem::path& folder, const Snapshot& model,
                         const LayerOptions& options);

// The same as one ZIP archive. Errors: those of the file, no material, or a temporary folder that
// is not writable.
Status write_layers_zip(const std::filesystem::path& path, const Snapshot& model,
                        const LayerOptions& options);

}  // namespace kibori
