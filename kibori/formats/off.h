// SPDX-License-Identifier: MIT
// Reads OFF files (Geomview's object file format). Internal to `formats` and kibori-import.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Parses an OFF file (text). Returns its vertices and faces. The first word may be missing. It is
// OFF, with optional prefixes: ST (texture coordinates), C (colours), N (normals), 4 (a fourth
// coordinate, which divides the others) and n. After n, the file has the dimension, which must be
// 3. Usually, each vertex and each face is in a separate line, and more numbers in the line are
// skipped. If the file has fewer lines, the prefixes define how many numbers a vertex has. `name`
// is the file's name in messages. `notes` receives sentences about what was left out. Errors (with
// line): another dimension; a binary file; a count that exceeds the file; a word that should be a
// number; an index of a missing vertex.
Result<TriangleMesh> parse_off(std::string_view text, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
