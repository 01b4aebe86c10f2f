// SPDX-License-Identifier: MIT
// Alpha textures: grey patterns that modulate the falloff of a brush. Each is a square that repeats
// in both directions. It is aligned with the stroke: u runs along the path and v across it, and the
// square is as wide as the brush. So the dabs of a stroke continue one pattern.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>

namespace kibori {

enum class Alpha {
  none,
  scales,
  bark,
  hatching,
  leather,
  cracks,
  pores,
  weave,
  knit,
  hammered,
  fur,
  ripples,
  studs,
  picture  // the brush has its own: AlphaPicture
};
constexpr Names<14> names_of(Alpha) {
  return {"none",  "scales", "bark",     "hatching", "leather", "cracks", "pores",
          "weave", "knit",   "hammered", "fur",      "ripples", "studs",  "picture"};
}

// A user's picture as a texture. Black has no effect, white the full effect.
struct AlphaPicture {
  // A dab has fewer cells across than that, so a larger picture would show no more.
  static constexpr int kSide = 256;

  // Rows start at v = 0, which is the bottom of the picture.
  std::array<uint8_t, kSide * kSide> greys{};

  bool operator==(const AlphaPicture&) const = default;
};

// Reads a PNG and scales it to the square of a texture. Colours become their luminance. Errors:
// those of parse_png_grey; more than kMaxPictureSide pixels on a side. `name`: for messages.
inline constexpr int kMaxPictureSide = 1024;
Result<std::shared_ptr<const AlphaPicture>> parse_alpha_picture(std::span<const char> png,
                                                                const std::string& name);
Result<std::shared_ptr<const AlphaPicture>> read_alpha_picture(const std::filesystem::path& path);

// The texture at (u, v), from 0 (the brush has no effect) to 1 (its full effect). It is
// interpolated and repeats with a period of 1. `none` is 1, and so is `picture`: use the
// second function for it. The result is the same on every machine. The first call for a texture
// computes it, which takes some ms. Calls may come from any thread.
double alpha_at(Alpha alpha, double u, double v);
double alpha_at(const AlphaPicture& picture, double u, double v);

// Directions and offset of the texture at a dab. Directions are unit vectors along and across the
// path.
struct AlphaFrame {
  Vec3 along = Vec3::UnitX(), across = Vec3::UnitY();
  double shift = 0;  // u at the dab's centre
};

}  // namespace kibori
