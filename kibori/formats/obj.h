// SPDX-License-Identifier: MIT
// Reads OBJ files. surface_file.h writes them. Internal to `formats` and kibori-import.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Parses an OBJ file. Returns the vertices and the faces of all objects and groups. Colours,
// texture coordinates, normals and materials are skipped; they may be missing. A backslash
// continues a line of numbers, but not a comment or a name. `name` is the file's name in messages.
// `notes` receives sentences about what was left out. Errors (with line): a word that should be a
// number; an index of a missing vertex; a file without faces.
Result<TriangleMesh> parse_obj(std::string_view text, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
