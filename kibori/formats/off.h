// SPDX-License-Identifier: MIT
// Reads OFF files (Geomview's object file format). Internal to `formats` and kibori-import.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Returns the vertices and faces of a text file. The first word is OFF, or is missing. It may have
// prefixes: ST (texture coordinates), C (colours), N (normals), 4 (a fourth coordinate, which
// divides the others) and n. With n, the dimension follows; it must be 3. Usually, each vertex and
// each face has its own line, and further numbers in the line are skipped. If the file has fewer
// lines, the prefixes determine how many numbers a vertex has. `name` is for messages; `notes`
// receives what was left out. Errors (with line): other dimensions, binary files, counts that
// exceed the file, words where numbers should be, indices of missing vertices.
Result<TriangleMesh> parse_off(std::string_view text, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
