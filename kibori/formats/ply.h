// SPDX-License-Identifier: MIT
// PLY, the polygon file format of Stanford's archive, with triangle strips (element `tristrips`),
// as scan archives pack their meshes. Writing: see surface_file.h.
#pragma once

#include <span>
#include <string>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Vertices, faces and triangle strips of an ASCII or binary file; other elements and properties are
// passed by. Within a strip -1 begins another, every second triangle is turned about, and triangles
// that name a vertex twice are left out; a face of more than three corners becomes a fan. `name` is
// for messages. Errors (with line, or element and row): no PLY, a header that can't be, a file too
// short for its counts, words where numbers should be, coordinates that are not finite, indices of
// vertices that are not there.
Result<TriangleMesh> parse_ply(std::span<const char> bytes, const std::string& name);

}  // namespace kibori
