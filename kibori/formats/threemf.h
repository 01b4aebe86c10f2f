// SPDX-License-Identifier: MIT
// Reads 3MF files (3D Manufacturing Format): the core specification, and the production extension
// (objects in other model files of the archive). Colours and materials are skipped. surface_file.h
// writes 3MF.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Parses a 3MF file. Returns the objects that its build section lists as one mesh in mm, each at
// its place. Objects that are not material are left out: supports, and the modifiers and negative
// parts of a slicer's project. `name` is the file's name in messages. `notes` receives sentences
// about what was left out, and about violations of the specification that do not prevent reading.
// Errors (with the entry and the line): the file is not an archive; there is no model; the XML is
// malformed or has a document type declaration; another extension is required; a number or an index
// is invalid; a component contains itself; there are more than kMaxImportTriangles.
Result<TriangleMesh> parse_3mf(std::span<const char> bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
