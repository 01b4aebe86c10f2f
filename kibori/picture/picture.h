// SPDX-License-Identifier: MIT
// Draws ray-traced pictures for papers. The scene has a large soft lamp, light from the whole sky,
// a ground, and a white background. Wood is a solid texture, so cuts show its rings correctly.
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

// A picture with 8 bits per channel (sRGB). The first row is the top row.
struct Image {
  int width = 0, height = 0;
  std::vector<std::array<uint8_t, 3>> pixels;
};

// Returns the direction in which the camera looks, for a name; z is up. Names: iso, front (along
// +y), back, left, right, top, bottom. Returns nullopt for any other name.
std::optional<Vec3> view_named(const std::string& name);

enum class Look { wood, plain };

// Returns the contrast of a material's rings, by the material's name. It is 0 without rings (stone,
// wax, clay, foam), and 1 for oak and pine. The server also sends it to the studio's page.
double ring_contrast(std::string_view material);

// Settings of a picture.
struct PictureOptions {
  int width = 1280, height = 960;
  Vec3 view = Vec3(-1, 1, -0.8);  // direction in which the camera looks; z is up
  Look look = Look::wood;
  // The box from which the wood was cut [mm]. It keeps the rings in place when the model changes.
  // Default: the bounds.
  std::optional<Box> plank;
  LogCut log;  // how the plank was cut from its log
  // Contrast of the rings for each material number (ring_contrast). Materials beyond the list have
  // 1.
  std::vector<double> contrasts;
  // Number of paths per pixel at edges. Within a face, about a twelfth is traced, because the light
  // is smoothed there.
  int samples = 48;
  int threads = 1;  // the picture does not depend on it
  std::function<void(double)> progress;
};

// Draws the surface. The surface fills the frame and stands on the ground. `colors` has the colours
// of the materials. Painted vertices have the colour of their paint. Errors: nothing to draw; a
// size outside 16 ... 16384 pixels; a zero view direction.
Result<Image> draw_picture(const Surface& surface, std::span<const std::array<uint8_t, 3>> colors,
                           const PictureOptions& options);

}  // namespace kibori
