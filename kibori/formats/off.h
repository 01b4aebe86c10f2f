// SPDX-License-Identifier: MIT
// The OFF reader (Geomview's object file format). Internal to `formats` and kibori-import.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Vertices and faces of a text file. The first word is OFF. It may be missing, and may have the
// prefixes ST (texture coordinates), C (colours), N (normals) and 4 (a fourth coordinate, which
// divides the others). Each vertex has its own line. In a file with fewer lines, the numbers of a
// vertex are counted. `name` is for messages; `notes` receives what was left out. Errors (with
// line): other dimensions, binary files, counts that exceed the file, words where numbers should
// be, indices of missing vertices.
Result<TriangleMesh> parse_off(std::string_view text, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
