// SPDX-License-Identifier: MIT
// 3MF, the 3D Manufacturing Format: core specification, colours from the materials extension, parts
// of the production extension. Writing: see surface_file.h.
#pragma once

#include <span>
#include <string>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The objects that the file's build names, placed and united, in mm. `name` is for messages. Errors
// (with entry and line): no archive, no model, malformed XML or a document type declaration,
// numbers or indices that can't be, components inside each other without end, more than
// kMaxImportTriangles.
Result<TriangleMesh> parse_3mf(std::span<const char> bytes, const std::string& name);

}  // namespace kibori
