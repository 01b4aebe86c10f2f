// SPDX-License-Identifier: MIT
// Writes surfaces to files. Inside Kibori, coordinates are in mm with Z up. The writers convert
// them if the format has another unit or other axes.
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

// Returns the colour of a vertex: its paint if there is one, otherwise the colour of its material.
// Returns white if the material has no colour.
Rgb color_of(const SurfaceVertex& vertex, std::span<const Rgb> material_colors);

// A function that passes a surface to the given sink, piece by piece.
using SurfaceSource = std::function<void(const SurfaceSink&)>;

// One of several surfaces in a file.
struct SurfaceObject {
  std::string name;  // UTF-8
  Pose pose;         // moves the surface's coordinates to their place in the file [mm]
  SurfaceSource surface;
};

// Writes one surface. The ending of `path` selects the format:
//   .stl  binary; only positions; mm
//   .ply  binary; normals and colours; mm
//   .obj  text; normals; colours after the positions, where most programs read them; mm
//   .3mf  colours; mm
//   .glb  normals and colours; metres, Y up
// The formats in mm keep every bit of the coordinates. Memory use is small, because temporary files
// next to `path` hold the data that must be written last. Errors: the ending is unknown; the
// surface has no triangles; it has more triangles or bytes than the format can count; a file cannot
// be written. After an error, there is no partial file.
Status write_surface(const std::filesystem::path& path, const SurfaceSource& surface,
                     std::span<const Rgb> material_colors);
// Writes several surfaces. In .3mf and .glb files, each surface is a separate object with its name,
// its own coordinates and its pose. In .obj files, each is an object with its name, and its pose is
// applied to the coordinates. In .stl and .ply files, the poses are applied, and there is one
// object.
Status write_objects(const std::filesystem::path& path, std::span<const SurfaceObject> objects,
                     std::span<const Rgb> material_colors);

// Returns Ok if write_surface supports the ending of `path`. Otherwise, returns an error sentence.
Status check_surface_ending(const std::filesystem::path& path);

}  // namespace kibori
