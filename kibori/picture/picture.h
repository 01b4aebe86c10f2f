// SPDX-License-Identifier: MIT
// Pictures one would put in a paper: ray traced, a large soft light, light from the whole sky,
// ground, white background; wood as a solid texture, so that its rings show where it was cut.
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

namespace kibori {

// 8 bits a channel, sRGB, rows from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<std::array<uint8_t, 3>> pixels;
};

// The way the camera looks, Z up, for iso, front (along +y), back, left, right, top or bottom;
// nothing for any other word.
std::optional<Vec3> view_named(const std::string& name);

enum class Look { wood, plain };

// How strongly the rings of a material stand out, from 0 (none: stone, wax, clay, foam) to 1 (oak,
// pine), by what its name says. Pages are told it.
double ring_contrast(std::string_view material);

struct PictureOptions {
  int width = 1280, height = 960;
  Vec3 view = Vec3(-1, 1, -0.8);  // the way the camera looks, Z up
  Look look = Look::wood;
  // What the wood was cut from [mm], so that rings stay where they are; default: the bounds.
  std::optional<Box> plank;
  // Of rings, by material (ring_contrast()); what is not in it has 1.
  std::vector<double> contrasts;
  int samples = 48;  // paths a pixel; noise falls with their root
  int threads = 1;   // the picture does not depend on it
  std::function<void(double)> progress;
};

// The surface, filling the frame and standing on the ground. `colors` are those of materials; what
// has paint shows its paint. Errors: nothing to draw, a size out of 16 ... 16384 pixels,
// a view without direction.
Result<Image> draw_picture(const Surface& surface, std::span<const std::array<uint8_t, 3>> colors,
                           const PictureOptions& options);

}  // namespace kibori
