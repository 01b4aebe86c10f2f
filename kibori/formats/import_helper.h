// SPDX-License-Identifier: MIT
// Connects this process with kibori-import, the program that runs the parsers of meshes and
// labelled volumes. The helper gets the path of a file and an open memory file. It has limits on
// memory and time, and it may crash.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/label_volume.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Reads a mesh with kibori-import. The program is searched in $KIBORI_IMPORT, next to the running
// program, and on the PATH. `notes` receives what the parser left out. Errors: the parser's
// message, or one sentence about how the helper ended (crash, memory, time).
Result<TriangleMesh> read_in_helper(const std::filesystem::path& path,
                                    std::vector<std::string>* notes = nullptr);

// The same for a labelled volume. Its values are 0 for air.
Result<LabelVolume> read_volume_in_helper(const std::filesystem::path& path);

// For the helper. limit_helper lowers this process's limits to what a file of this size can need.
// The size of a .gltf file includes the .bin files in its folder.
// The others write a mesh and its notes, or a volume, to the memory file. All return false if they
// fail.
bool limit_helper(const std::filesystem::path& path);
bool send_mesh(const TriangleMesh& mesh, const std::vector<std::string>& notes);
bool send_volume(const LabelVolume& volume);
// For the helper. After this call, this process cannot open a file or a socket, or start a program.
// The kernel enforces this as far as it can (Landlock since Linux 5.13, and seccomp). Handles that
// are open stay open.
void confine_helper();
// The same, but files below `folder` can be read. confine_helper takes that away, too. Without
// Landlock, all files can be read until then.
void confine_helper_to(const std::filesystem::path& folder);

}  // namespace kibori
