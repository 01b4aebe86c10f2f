// SPDX-License-Identifier: MIT
// Reads PLY files (Stanford's polygon file format), with triangle strips (element `tristrips`),
// which scan archives use. surface_file.h writes PLY files.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Parses an ASCII or binary file. Returns the vertices, faces and triangle strips. The elements may
// be in any order. Other elements and properties are skipped. In a list of strips, -1 begins the
// next strip, and every second triangle of a strip is reversed. Triangles of a strip that use a
// vertex twice are left out. `name` is the file's name in messages. `notes` receives sentences
// about what was left out. Errors (with the line, or with the element and the row): the file is not
// a PLY file; its header is invalid; it is too short for its counts; a word should be a number; a
// coordinate is not finite; an index is of a missing vertex; the file has only points.
Result<TriangleMesh> parse_ply(std::span<const char> bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
