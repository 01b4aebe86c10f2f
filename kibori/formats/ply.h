// SPDX-License-Identifier: MIT
// Reads PLY files (Stanford's polygon file format). Triangle strips are read, too (element
// `tristrips`), because scan archives use them. surface_file.h writes PLY files.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Returns the vertices, faces and triangle strips of an ASCII or binary file. The elements may be
// in any order. Other elements and properties are skipped. In a strip, -1 begins another strip, and
// every second triangle is reversed. A strip's triangles that use a vertex twice are left out.
// `name` is for messages; `notes` receives what was left out. Errors (with line, or element and
// row): not a PLY file, an invalid header, a file too short for its counts. Also words where
// numbers should be, coordinates that are not finite, indices of vertices that do not exist, only
// points.
Result<TriangleMesh> parse_ply(std::span<const char> bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
