// SPDX-License-Identifier: MIT
// Alpha textures: grey patterns that modulate the falloff of a brush. Each pattern is a square that
// repeats in both directions. u runs along the path of the stroke, and v across it. The square is
// as wide as the brush. The dabs of a stroke continue one pattern.
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
  picture  // the user's picture: AlphaPicture
};
constexpr Names<14> names_of(Alpha) {
  return {"none",  "scales", "bark",     "hatching", "leather", "cracks", "pores",
          "weave", "knit",   "hammered", "fur",      "ripples", "studs",  "picture"};
}

// A user's picture as a texture. Black has no effect, white the full effect.
struct AlphaPicture {
  // Side of the stored square [pixels]. A dab is fewer cells wide than this, so a larger picture
  // would not show more detail.
  static constexpr int kSide = 256;

  // Grey values, row by row. Rows start at v = 0, which is the bottom of the picture.
  std::array<uint8_t, kSide * kSide> greys{};

  bool operator==(const AlphaPicture&) const = default;
};

// Reads a PNG and scales it to the square of a texture. Colours become grey by their luminance.
// `name` is the picture's name in messages. Errors: parse_png_grey rejects the PNG; a side has more
// than kMaxPictureSide pixels; read_alpha_picture cannot read the file.
inline constexpr int kMaxPictureSide = 1024;
Result<std::shared_ptr<const AlphaPicture>> parse_alpha_picture(std::span<const char> png,
                                                                const std::string& name);
Result<std::shared_ptr<const AlphaPicture>> read_alpha_picture(const std::filesystem::path& path);

// Returns the texture at (u, v): 0 if the brush has no effect there, 1 for the full effect. The
// value is interpolated, and repeats with a period of 1. For `none` and `picture`, the first
// function returns 1; the second function is for pictures. The result is the same on every machine.
// The first call for a texture takes some ms, because it computes the texture. Calls may come from
// any thread.
double alpha_at(Alpha alpha, double u, double v);
double alpha_at(const AlphaPicture& picture, double u, double v);

// Position of the texture at a dab. `along` and `across` are unit vectors, along the path and
// across it.
struct AlphaFrame {
  Vec3 along = Vec3::UnitX(), across = Vec3::UnitY();
  double shift = 0;  // u at the dab's centre
};

}  // namespace kibori
