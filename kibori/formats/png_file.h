// SPDX-License-Identifier: MIT
// PNG pictures and 16-bit grey maps.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <kibori/base/result.h>

namespace kibori {

// Rows from the top. Errors: those of the file.
Status write_png_rgb(const std::filesystem::path& path, int width, int height,
                     std::span<const std::array<uint8_t, 3>> pixels);
// The same in memory.
Result<std::vector<uint8_t>> png_rgb(int width, int height,
                                     std::span<const std::array<uint8_t, 3>> pixels);
Status write_png_grey8(const std::filesystem::path& path, int width, int height,
                       std::span<const uint8_t> pixels);
Status write_png_grey16(const std::filesystem::path& path, int width, int height,
                        std::span<const uint16_t> pixels);

struct GreyMap {
  int width = 0, height = 0;
  // Rows from the top; 0 black, 65535 white, whatever the file's depth.
  std::vector<uint16_t> pixels;
};

// Any PNG as grey: colours by their luminance, transparency over black. Errors: no PNG, damaged,
// more than 8192 pixels a side.
Result<GreyMap> read_png_grey(const std::filesystem::path& path);
Result<GreyMap> parse_png_grey(std::span<const char> bytes, const std::string& name);

}  // namespace kibori
