// SPDX-License-Identifier: MIT
// Both ends of the wire between this process and kibori-import, the program that runs other
// people's parsers. It gets a file's path and an open memory file; it has limits on memory and
// time; it may crash.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Reads a mesh by kibori-import, which is looked for in $KIBORI_IMPORT, beside the running program,
// and on the PATH. Errors: what the parser says, or one sentence on how it ended (crash, memory,
// time).
Result<TriangleMesh> read_in_helper(const std::filesystem::path& path);

// The helper's end: lowers this process's limits to what a file of this size can need, and writes a
// mesh to the memory file. False where that is not possible.
bool limit_helper(const std::filesystem::path& path);
bool send_mesh(const TriangleMesh& mesh);
// From here on this process opens no file, no socket, and starts no program, as far as the kernel
// can see to that (Landlock since Linux 5.13, and seccomp); handles that are open stay so.
void confine_helper();

}  // namespace kibori
