// SPDX-License-Identifier: MIT
// Cross-sections and height maps. They are computed from the dexels, without a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// The cross-section of a model in the horizontal plane through its nodes of index `k` along z.
struct Layer {
  double z_mm;
  // Closed outlines [mm, x and y in the world]. The first point of an outline is not repeated.
  // Material is to the left of outlines, so holes run clockwise. Outlines never cross or touch each
  // other.
  std::vector<std::vector<std::array<double, 2>>> outlines;
};

// Computes a cross-section. Outlines pass through the ends of the x and y dexels in that plane, to
// 1e-4 cells. Between two ends, an outline is straight, so it cuts off a corner between the ends.
Layer slice_layer(const Snapshot& model, int k);

// Returns a picture of the nodes of index `k` along z: 255 inside, 0 outside. Each row has one
// pixel for each node along x, also for the nodes that growth added. The first row has the largest
// y.
std::vector<uint8_t> mask_layer(const Snapshot& model, int k);

// Divides the height from the lowest to the highest material into slices. Their thickness is
// `layer_mm`, or one pitch if that is larger. Returns, for each slice, the index along z of the
// nodes that are nearest to its middle. The list is empty if there is no material. Requires
// layer_mm > 0.
std::vector<int> layers_of(const Snapshot& model, double layer_mm);

// Heights of the material's top, seen from above. Each ray along z has a value. 0 means no
// material. 1 means `low_mm`, the height of the lowest top. 65535 means `high_mm`, the height of
// the highest top. Each row has one pixel for each node along x. The first row has the largest y.
struct HeightMap {
  int width = 0, height = 0;
  double low_mm = 0, high_mm = 0;
  std::vector<uint16_t> pixels;
};
HeightMap height_map(const Snapshot& model);

}  // namespace kibori
