// SPDX-License-Identifier: MIT
// Results that come from the dexels without a mesh: cross-sections and height maps.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// The cross-section of a model with the horizontal plane through its nodes of index `k` along z.
struct Layer {
  double z_mm;
  // Closed outlines [mm, world x y]. The first point is not repeated. Material is to the left, so
  // holes run clockwise. Outlines never cross or touch.
  std::vector<std::vector<std::array<double, 2>>> outlines;
};

// Outlines pass exactly through the ends of the x and y dexels of that plane. Between two ends they
// are straight, so a corner between them is cut off.
Layer slice_layer(const Snapshot& model, int k);

// A picture of the nodes of index `k` along z: 255 inside, 0 outside. Each row has one pixel for
// each node along x, including those that growth added. The row of the largest y is first.
std::vector<uint8_t> mask_layer(const Snapshot& model, int k);

// Divides the height from the lowest to the highest material into slices of thickness `layer_mm`.
// Returns the index along z of the nodes nearest to the middle of each slice. Empty if there is no
// material. Requires layer_mm > 0.
std::vector<int> layers_of(const Snapshot& model, double layer_mm);

// Heights of the surface, seen from above. Each ray along z has a value: 1 means `low_mm`, the
// height of the lowest top, and 65535 means `high_mm`, that of the highest. 0 means no material.
// Each row has one pixel for each node along x, and the row of the largest y is first.
struct HeightMap {
  int width = 0, height = 0;
  double low_mm = 0, high_mm = 0;
  std::vector<uint16_t> pixels;
};
HeightMap height_map(const Snapshot& model);

}  // namespace kibori
