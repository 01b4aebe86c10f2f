// SPDX-License-Identifier: MIT
// Reads 3MF, the 3D Manufacturing Format: the core specification, and objects in other model files
// of the archive (production extension). Colours and materials are skipped. surface_file.h writes
// 3MF.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Returns the objects that the file's build section lists, each transformed to its place, as one
// mesh in mm. Objects that are not material are left out: supports, and the modifiers and negative
// parts of a slicer's project. `name` is for messages. `notes` receives what was left out, and
// violations of the specification that do not prevent reading. Errors (with entry and line): not an
// archive, no model, malformed XML or a document type declaration, other required extensions. Also
// invalid numbers or indices, components that contain themselves, more than kMaxImportTriangles.
Result<TriangleMesh> parse_3mf(std::span<const char> bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
