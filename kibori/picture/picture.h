// SPDX-License-Identifier: MIT
// Ray-traced pictures for papers: a large soft lamp, light from the whole sky, a ground, a white
// background. Wood is a solid texture, so cuts show its rings correctly.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>
#include <kibori/geometry/wood.h>

namespace kibori {

// 8 bits per channel, sRGB, rows from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<std::array<uint8_t, 3>> pixels;
};

// The direction in which the camera looks, Z up. Names: iso, front (along +y), back, left, right,
// top, bottom. nullopt for any other word.
std::optional<Vec3> view_named(const std::string& name);

enum class Look { wood, plain };

// The contrast of a material's rings, by its name: from 0 (none: stone, wax, clay, foam) to 1 (oak,
// pine). The server sends it to the studio's page, too.
double ring_contrast(std::string_view material);

// Settings of a picture.
struct PictureOptions {
  int width = 1280, height = 960;
  Vec3 view = Vec3(-1, 1, -0.8);  // direction in which the camera looks, Z up
  Look look = Look::wood;
  // The box that the wood was cut from [mm], so that rings stay in place. Default: the bounds.
  std::optional<Box> plank;
  LogCut log;  // how the plank was cut from its log
  // Contrast of the rings by material number (ring_contrast()). Materials beyond the list have 1.
  std::vector<double> contrasts;
  // Paths per pixel at edges. Within a face, about a twelfth is traced, because light is smoothed.
  int samples = 48;
  int threads = 1;  // the picture does not depend on it
  std::function<void(double)> progress;
};

// Draws the surface. It fills the frame and stands on the ground. `colors` are the materials'
// colours. Painted vertices show their paint. Errors: nothing to draw, a size outside 16 ... 16384
// pixels, a zero view direction.
Result<Image> draw_picture(const Surface& surface, std::span<const std::array<uint8_t, 3>> colors,
                           const PictureOptions& options);

}  // namespace kibori
