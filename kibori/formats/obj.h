// SPDX-License-Identifier: MIT
// Reads OBJ files. surface_file.h writes them. Internal to `formats` and kibori-import.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Returns the vertices and faces of all objects and groups. Colours, texture coordinates, normals
// and materials are skipped, and references to missing ones are accepted. A backslash continues a
// line of numbers, not a comment or a name. `name` is for messages; `notes` receives what was left
// out. Errors (with line): words where numbers should be, indices of vertices that do not exist.
// Also no faces.
Result<TriangleMesh> parse_obj(std::string_view text, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
