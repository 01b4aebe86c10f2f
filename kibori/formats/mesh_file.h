// SPDX-License-Identifier: MIT
// Reads triangle meshes from files. Every file counts as hostile until it is parsed. Every count is
// checked against the available bytes, and every number must be finite. This process reads STL
// (binary and ASCII). The program kibori-import reads all other formats. Therefore, a parser that
// crashes or runs out of memory causes one error message here.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The mesh in mm with Z up: .stl, .obj, .ply and .off have no units and are taken as they are; .3mf
// is scaled by its unit; .glb and .gltf are turned from Y up and scaled from metres. `notes`
// receives a sentence, with the file's name, for everything that was left out. Errors: unknown
// ending, unreadable, malformed (with byte or line), no triangles, non-finite coordinates, more than
// kMaxImportTriangles, what read_in_helper says.
Result<TriangleMesh> read_mesh(const std::filesystem::path& path,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
