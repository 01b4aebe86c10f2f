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

// Outlines pass exactly through the ends of the x and y dexels of that plane. Between two dexels,
// an outline cuts the corner by a straight line.
Layer slice_layer(const Snapshot& model, int k);

// 255 if the node is inside, 0 otherwise. Each row has nodes.x() pixels. The row of the largest y
// is first, as in pictures.
std::vector<uint8_t> mask_layer(const Snapshot& model, int k);

// The node layers nearest to the middles of slices of `layer_mm`, from the lowest to the highest
// material. Empty if there is no material. Requires layer_mm > 0.
std::vector<int> layers_of(const Snapshot& model, double layer_mm);

// Heights seen from above. Each z ray has 1 ... 65535 for `low_mm` to `high_mm`, the lowest and the
// highest top. 0 means no material. Each row has nodes.x() pixels, and the row of the largest y is
// first.
struct HeightMap {
  int width = 0, height = 0;
  double low_mm = 0, high_mm = 0;
  std::vector<uint16_t> pixels;
};
HeightMap height_map(const Snapshot& model);

}  // namespace kibori
