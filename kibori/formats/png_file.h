// SPDX-License-Identifier: MIT
// Reads and writes PNG pictures and 16-bit grey maps.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <kibori/base/result.h>

namespace kibori {

// Rows start at the top. Errors: those of the file.
Status write_png_rgb(const std::filesystem::path& path, int width, int height,
                     std::span<const std::array<uint8_t, 3>> pixels);
// The same in memory.
Result<std::vector<uint8_t>> png_rgb(int width, int height,
                                     std::span<const std::array<uint8_t, 3>> pixels);
Status write_png_grey8(const std::filesystem::path& path, int width, int height,
                       std::span<const uint8_t> pixels);
Status write_png_grey16(const std::filesystem::path& path, int width, int height,
                        std::span<const uint16_t> pixels);

// A grey picture with 16 bits per pixel.
struct GreyMap {
  int width = 0, height = 0;
  // Rows start at the top. 0 is black and 65535 white, for any depth of the file.
  std::vector<uint16_t> pixels;
};

// Reads any PNG as grey. Colours become their luminance, and transparent pixels are drawn over
// black. Errors: not a PNG, damaged, more than 8192 pixels a side.
Result<GreyMap> read_png_grey(const std::filesystem::path& path);
Result<GreyMap> parse_png_grey(std::span<const char> bytes, const std::string& name);

}  // namespace kibori
