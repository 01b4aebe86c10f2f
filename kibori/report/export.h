// SPDX-License-Identifier: MIT
// What a model can be written as without a mesh: a height map, a stack of layers.
#pragma once

#include <filesystem>
#include <functional>

#include <kibori/base/result.h>
#include <kibori/surface/layers.h>

namespace kibori {

struct HeightMapSummary {
  int width = 0, height = 0;
  double low_mm = 0, high_mm = 0;  // of grey 1 and 65535; 0 is no material
};
// A 16-bit grey PNG, one pixel a ray. Errors: those of the file, no material.
Result<HeightMapSummary> write_height_map(const std::filesystem::path& path, const Snapshot& model);

enum class LayerFormat { svg, png };

struct LayerOptions {
  double layer_mm = 0.2;  // between layers; those nearer than the pitch become one
  LayerFormat format = LayerFormat::svg;
  int threads = 1;
  std::function<void(double)> progress;
};
// layer-0001.svg or .png, from below, into `folder`, which is made if need be; SVG in mm, a path
// with even-odd filling, PNG black and white, one pixel a node. The number of layers. Errors: a
// folder that can't be written, no material.
Result<int> write_layers(const std::filesystem::path& folder, const Snapshot& model,
                         const LayerOptions& options);

// The same as one ZIP archive. Errors: the file, no material, a temporary folder that can't be
// written.
Status write_layers_zip(const std::filesystem::path& path, const Snapshot& model,
                        const LayerOptions& options);

}  // namespace kibori
