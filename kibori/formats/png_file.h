// SPDX-License-Identifier: MIT
// Writes PNG pictures, and reads them as 16-bit grey maps.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <kibori/base/result.h>

namespace kibori {

// Write pictures. The first row of `pixels` is the top. Errors: the file cannot be written.
Status write_png_rgb(const std::filesystem::path& path, int width, int height,
                     std::span<const std::array<uint8_t, 3>> pixels);
// Returns a picture as the bytes of a PNG file.
Result<std::vector<uint8_t>> png_rgb(int width, int height,
                                     std::span<const std::array<uint8_t, 3>> pixels);
Status write_png_grey8(const std::filesystem::path& path, int width, int height,
                       std::span<const uint8_t> pixels);
Status write_png_grey16(const std::filesystem::path& path, int width, int height,
                        std::span<const uint16_t> pixels);

// A grey picture with 16 bits per pixel.
struct GreyMap {
  int width = 0, height = 0;
  // The first row is the top. 0 is black and 65535 is white, for any bit depth of the file.
  std::vector<uint16_t> pixels;
};

// Reads any PNG picture as grey. Colours become grey by their luminance. Transparent pixels are
// blended with black. Errors: the file is not a PNG picture, or is damaged; a side has more than
// `max_side` pixels (read_png_grey: kMaxPngSide).
inline constexpr int kMaxPngSide = 8192;
Result<GreyMap> read_png_grey(const std::filesystem::path& path);
Result<GreyMap> parse_png_grey(std::span<const char> bytes, const std::string& name,
                               int max_side = kMaxPngSide);

}  // namespace kibori
