// SPDX-License-Identifier: MIT
// What the dexels say without a mesh: cross-sections and heights.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// The cross-section of a model with the horizontal plane through its nodes of index `k` along z.
struct Layer {
  double z_mm;
  // Closed outlines [mm, world x y], the first point not repeated; material lies to the left, so
  // holes run clockwise. Outlines never cross or touch.
  std::vector<std::vector<std::array<double, 2>>> outlines;
};

// Outlines pass exactly through the ends of the x and y dexels of that plane; corners between two
// dexels are cut.
Layer slice_layer(const Snapshot& model, int k);

// 255 where the node is inside, 0 elsewhere; nodes.x() a row, the farthest y first, as pictures go.
std::vector<uint8_t> mask_layer(const Snapshot& model, int k);

// The node layers nearest to the middles of layers of `layer_mm` from the lowest material to the
// highest; empty without material. layer_mm > 0.
std::vector<int> layers_of(const Snapshot& model, double layer_mm);

// Heights seen from above: per z ray 1 ... 65535 from `low_mm` to `high_mm`, the lowest and highest
// tops; 0 without material. nodes.x() a row, the farthest y first.
struct HeightMap {
  int width = 0, height = 0;
  double low_mm = 0, high_mm = 0;
  std::vector<uint16_t> pixels;
};
HeightMap height_map(const Snapshot& model);

}  // namespace kibori
