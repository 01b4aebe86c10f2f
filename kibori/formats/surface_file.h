// SPDX-License-Identifier: MIT
// Writes surfaces to files. Coordinates inside Kibori are in mm with Z up. Formats with other units
// or axes are converted.
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

// The colour of a vertex: its paint if it has one, otherwise the colour of its material. White if
// the material has no colour.
Rgb color_of(const SurfaceVertex& vertex, std::span<const Rgb> material_colors);

// Calls its sink with the surface, piece by piece.
using SurfaceSource = std::function<void(const SurfaceSink&)>;

// One of several surfaces in a file.
struct SurfaceObject {
  std::string name;  // UTF-8
  Pose pose;         // transforms its coordinates to those of the file [mm]
  SurfaceSource surface;
};

// Writes one surface. The file's ending selects the format:
//   .stl  binary; positions only; mm
//   .ply  binary; normals and colours; mm
//   .obj  text; normals, and colours after the positions, as most programs read them; mm
//   .3mf  colours; mm
//   .glb  normals and colours; metres, Y up
// The first four preserve every coordinate in mm to the bit. Memory use is small: temporary files
// next to the output hold the data that is written last. Errors: unknown ending, a surface without
// triangles, more triangles or bytes than the format can count, a file that cannot be written. An
// error leaves no partial file.
Status write_surface(const std::filesystem::path& path, const SurfaceSource& surface,
                     std::span<const Rgb> material_colors);
// Writes several surfaces. .3mf and .glb store each as a separate object with its name, its own
// coordinates and its pose. .obj stores each as an object with its name, and the pose is applied to
// its coordinates. .stl and .ply apply the poses and store one object.
Status write_objects(const std::filesystem::path& path, std::span<const SurfaceObject> objects,
                     std::span<const Rgb> material_colors);

// Ok if write_surface supports the ending, otherwise one sentence.
Status check_surface_ending(const std::filesystem::path& path);

}  // namespace kibori
