// SPDX-License-Identifier: MIT
// Surfaces into files, in mm with Z up, as the model is.
#pragma once

#include <array>
#include <filesystem>
#include <span>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// By the file's ending: .stl (binary, positions alone), .ply (binary, with normals and colours), .obj (with
// normals and colours after the positions, as most programs read them). Every coordinate comes back to the
// bit. A vertex has the colour it was painted, else that of its material, white for a material without one.
// Errors: unknown ending, more than 2^32 - 1 triangles for STL, a file that can't be written; nothing is
// half-written.
Status write_surface(const std::filesystem::path& path, const Surface& surface,
                     std::span<const std::array<uint8_t, 3>> material_colors);

// Ok if write_surface knows the ending, else one sentence.
Status check_surface_ending(const std::filesystem::path& path);

}  // namespace kibori
