// SPDX-License-Identifier: MIT
// Scenes that are stock alone: what one begins with to carve by hand. Materials are numbers of
// known_materials().
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <kibori/base/result.h>
#include <kibori/motion/scene.h>

namespace kibori {

// So fine at most along a stock's longest side, so that a page can show it.
inline constexpr double kMostRays = 1024;

// A block, log (`cylinder`: x is its diameter, z its length) or ball (x is its diameter) of a size [mm] and
// pitch [mm]. Errors: the size, the pitch, the material.
Result<Scene> stock_scene(Stock::Kind kind, const Vec3& size_mm, double pitch_mm, size_t material);

// A mesh or, as a relief, a picture (PNG). `longest_mm`: it is scaled so that its longest side is this; else
// a mesh stays as it is, and a picture is 80. `rays`: along that side. Reads the file for its size. Errors:
// those of reading it, and as above.
Result<Scene> file_scene(const std::filesystem::path& file, std::optional<double> longest_mm, double rays,
                         size_t material);

}  // namespace kibori
