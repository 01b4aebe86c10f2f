// SPDX-License-Identifier: MIT
// Writes a model as a height map or as a stack of layers, without a mesh.
#pragma once

#include <filesystem>
#include <functional>

#include <kibori/base/result.h>
#include <kibori/surface/layers.h>

namespace kibori {

// Size and range of a height map.
struct HeightMapSummary {
  int width = 0, height = 0;
  double low_mm = 0, high_mm = 0;  // heights of grey 1 and of grey 65535; grey 0: no material
};
// Writes a height map: a 16-bit grey PNG with one pixel per z ray. Errors: there is no material;
// the file cannot be written.
Result<HeightMapSummary> write_height_map(const std::filesystem::path& path, const Snapshot& model);

enum class LayerFormat { svg, png };

struct LayerOptions {
  double layer_mm = 0.2;  // distance between layers; at least the pitch
  LayerFormat format = LayerFormat::svg;
  int threads = 1;
  std::function<void(double)> progress;
};
// Writes the layers, from the lowest up, as layer-0001.svg (or .png) and so on into `folder`.
// Creates the folder if it does not exist. Removes the other layer files of an earlier stack. SVG
// files are in mm, with one path and even-odd filling. PNG files are black and white, with one
// pixel per node. Returns the number of layers. Errors: there is no material; the folder cannot be
// created; a file cannot be written.
Result<int> write_layers(const std::filesystem::path& folder, const Snapshot& model,
                         const LayerOptions& options);

// Writes the layers as one ZIP archive. Errors: as above; the temporary folder is not writable.
Status write_layers_zip(const std::filesystem::path& path, const Snapshot& model,
                        const LayerOptions& options);

}  // namespace kibori
