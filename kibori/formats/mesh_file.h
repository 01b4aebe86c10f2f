// SPDX-License-Identifier: MIT
// Reads triangle meshes from files. A file may be malicious. Therefore, every count is checked
// against the available bytes, and every number must be finite. This process reads STL (binary and
// ASCII). The program kibori-import reads all other formats. If a parser there crashes or runs out
// of memory, this process only gets an error message.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Returns the mesh of a file in mm. The numbers of .stl, .obj, .ply and .off files are taken as mm,
// and their axes are not changed. .3mf is scaled by its unit. .glb and .gltf are scaled from
// metres, and turned from Y up to Z up. `notes` receives a sentence, with the file's name, for
// everything that was left out. Errors: unknown ending, unreadable, malformed (with byte or line),
// no triangles, non-finite coordinates or some beyond kMaxCoordinate. Also more than
// kMaxImportTriangles, which .stl files may exceed, and the errors of read_in_helper.
Result<TriangleMesh> read_mesh(const std::filesystem::path& path,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
