// SPDX-License-Identifier: MIT
// The PLY reader (the polygon file format of Stanford's archive), with triangle strips (element
// `tristrips`), as scan archives pack their meshes. Writing: see surface_file.h.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Vertices, faces and triangle strips of an ASCII or binary file, in any order. Other elements and
// properties are skipped. In a strip, -1 begins another strip, and every second triangle is
// reversed. Triangles that use a vertex twice are left out. `name` is for messages; `notes`
// receives what was left out. Errors (with line, or element and row): not a PLY file, an invalid
// header, a file too short for its counts. Also words where numbers should be, coordinates that are
// not finite, indices of vertices that do not exist, only points.
Result<TriangleMesh> parse_ply(std::span<const char> bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
