// SPDX-License-Identifier: MIT
// Reads triangle meshes from files. A file may be malicious. Therefore, every count is checked
// against the available bytes, and every number must be finite. This process reads STL files
// (binary and ASCII). The program kibori-import reads all other formats. If it crashes or runs out
// of memory, this process only returns an error.
// of memory, this process only gets an error message.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Reads a mesh file. Returns the mesh with coordinates in mm. In .stl, .obj, .ply and .off files,
// the numbers are taken as mm, and the axes stay. A .3mf file states its unit. In .glb and .gltf
// files, the unit is metres, and y is up; the result has z up. `notes` receives sentences, with the
// file's name, about what was left out. Errors: the ending is unknown; the file cannot be read; its
// content is malformed (the message has the byte or the line); there are no triangles; a coordinate
// is not finite or beyond kMaxCoordinate; there are more than kMaxImportTriangles (no limit for
// .stl files); those of read_in_helper.
Result<TriangleMesh> read_mesh(const std::filesystem::path& path,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
