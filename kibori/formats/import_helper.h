// SPDX-License-Identifier: MIT
// Connects this process with kibori-import, the program that runs the parsers of meshes and
// labelled volumes. The helper gets the path of a file and writes its result to a memory file. Its
// memory and time are limited. If it crashes, this process returns an error.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/label_volume.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Reads a mesh with kibori-import. $KIBORI_IMPORT names that program. If it is not set, the program
// is looked for next to the running one and on the PATH. `notes` receives what the parser left out.
// Errors: the parser's message, or one sentence about how the helper ended (crash, memory, time).
Result<TriangleMesh> read_in_helper(const std::filesystem::path& path,
                                    std::vector<std::string>* notes = nullptr);

// Reads a labelled volume with kibori-import, which is found in the same way. The label 0 is air.
Result<LabelVolume> read_volume_in_helper(const std::filesystem::path& path);

// The functions below are for the helper. The three that return bool return false if they fail.
//
// Lowers this process's limits to what a file of this size can need. The size of a .gltf file
// includes the .bin files in its folder.
bool limit_helper(const std::filesystem::path& path);
// Write a mesh and its notes, or a volume, to the memory file.
bool send_mesh(const TriangleMesh& mesh, const std::vector<std::string>& notes);
bool send_volume(const LabelVolume& volume);
// After this call, this process cannot open a file or a socket, or start a program. Open handles
// stay open. The kernel enforces this with Landlock (since Linux 5.13) and, on x86-64 and ARM64,
// with seccomp. In sanitiser builds, this function does nothing.
void confine_helper();
// After this call, this process can read files below `folder`, and cannot open other files. Sockets
// are not restricted. Call confine_helper after it: that call also revokes access to `folder`. If
// the kernel has no Landlock, and in sanitiser builds, this function restricts nothing.
void confine_helper_to(const std::filesystem::path& folder);

}  // namespace kibori
