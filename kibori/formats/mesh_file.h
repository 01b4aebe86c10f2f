// SPDX-License-Identifier: MIT
// Triangle meshes from files, which are hostile until parsed: every count is checked against the
// bytes there are, every number must be finite. STL (binary and ASCII) is read in this process;
// everything else by the program kibori-import, so that a crash or a flood of memory in a parser is
// one sentence here.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The mesh in mm with Z up: .stl, .obj, .ply and .off have no units and are taken as they are; .3mf
// is scaled by its unit; .glb is turned from Y up and scaled from metres. Errors: unknown ending,
// unreadable, malformed (with byte or line), no triangles, non-finite coordinates, more than
// kMaxImportTriangles, what read_in_helper says.
Result<TriangleMesh> read_mesh(const std::filesystem::path& path);

// The same for the bytes of an STL file; `name` is for messages.
Result<TriangleMesh> parse_stl(const char* data, size_t size, const std::string& name);

}  // namespace kibori
