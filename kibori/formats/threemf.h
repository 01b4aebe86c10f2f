// SPDX-License-Identifier: MIT
// Reads 3MF, the 3D Manufacturing Format: core specification, colours from the materials extension,
// and parts of the production extension. surface_file.h writes 3MF.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The objects that the file's build names, placed and united, in mm. Modifiers, supports and
// negative parts of slicers' projects are left out. `name` is for messages; `notes` receives what
// was left out, and violations of the specification that do not prevent reading. Errors (with entry
// and line): not an archive, no model, malformed XML or a document type declaration, other required
// extensions. Also invalid numbers or indices, components that contain themselves, more than
// kMaxImportTriangles.
Result<TriangleMesh> parse_3mf(std::span<const char> bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
