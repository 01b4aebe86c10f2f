// SPDX-License-Identifier: MIT
// Surfaces into files. Inside everything is mm with Z up; formats that have other units or axes are
// converted.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

using Rgb = std::array<uint8_t, 3>;

// The colour of a vertex: the one it was painted, else that of its material, white for a material
// without one.
Rgb color_of(const SurfaceVertex& vertex, std::span<const Rgb> material_colors);

// Calls its sink with the surface, piece by piece.
using SurfaceSource = std::function<void(const SurfaceSink&)>;

// One of several surfaces in a file.
struct SurfaceObject {
  std::string name;  // UTF-8
  Pose pose;         // of its coordinates in the file's; mm
  SurfaceSource surface;
};

// By the file's ending:
//   .stl  binary; positions alone; mm
//   .ply  binary; normals and colours; mm
//   .obj  text; normals, and colours after the positions, as most programs read them; mm
//   .3mf  colours; mm
//   .glb  normals and colours; metres, Y up
// Every coordinate in mm comes back to the bit from the first four. Needs little memory: what must
// wait is spooled beside the file. Errors: unknown ending, a surface without triangles, more
// triangles or bytes than the format can count, a file that can't be written; nothing is
// half-written.
Status write_surface(const std::filesystem::path& path, const SurfaceSource& surface,
                     std::span<const Rgb> material_colors);
// Several: .3mf and .glb keep each as an object of its own, with its name, in its own coordinates
// and placed by its pose; .obj as an object where it stands; .stl and .ply all where they stand, as
// one.
Status write_objects(const std::filesystem::path& path, std::span<const SurfaceObject> objects,
                     std::span<const Rgb> material_colors);

// Ok if write_surface knows the ending, else one sentence.
Status check_surface_ending(const std::filesystem::path& path);

}  // namespace kibori
