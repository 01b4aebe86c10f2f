// SPDX-License-Identifier: MIT
// Triangle meshes from files. STL (binary and ASCII) is read here; OBJ and PLY through Assimp. Files are
// hostile until parsed: every count is checked against the bytes there are, every number must be finite.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The mesh in the file's own units and axes. Errors: unknown ending, unreadable, malformed (with byte or
// line), no triangles, non-finite coordinates, more than 2^31 - 1 triangle corners.
Result<TriangleMesh> read_mesh(const std::filesystem::path& path);

// The same for the bytes of an STL file; `name` is for messages.
Result<TriangleMesh> parse_stl(const char* data, size_t size, const std::string& name);

}  // namespace kibori
