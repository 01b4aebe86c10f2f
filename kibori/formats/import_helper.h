// SPDX-License-Identifier: MIT
// Connects this process with the helper: the program kibori-import, which runs the parsers of
// meshes and labelled volumes. The helper gets the path of a file, and writes its result to a
// memory file. The memory and the time of the helper are limited. If it crashes, this process only
// returns an error.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/label_volume.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Reads a mesh with the helper. The environment variable KIBORI_IMPORT names the helper's program.
// Without it, the program is searched next to the running program, and then on the PATH. `notes`
// receives sentences about what the parser left out. Errors: those of the parser; the helper does
// not start, crashes, returns an invalid mesh, or needs too much memory or time.
Result<TriangleMesh> read_in_helper(const std::filesystem::path& path,
                                    std::vector<std::string>* notes = nullptr);

// Reads a labelled volume with the helper. The label 0 means air. Errors: as for meshes.
Result<LabelVolume> read_volume_in_helper(const std::filesystem::path& path);

// The functions below are for the helper. Those that return bool return false if they fail.
//
// Lowers the limits of this process to what a file of this size can need. The size of a .gltf file
// includes all .bin files of its folder.
bool limit_helper(const std::filesystem::path& path);
// Write a mesh with its notes, or a volume, to the memory file.
bool send_mesh(const TriangleMesh& mesh, const std::vector<std::string>& notes);
bool send_volume(const LabelVolume& volume);
// Confines this process: from now on, it cannot open a file or a socket, or start a program. Files
// that are open stay open. The kernel enforces this by Landlock (since Linux 5.13) and, on x86-64
// and ARM64, by seccomp. In sanitiser builds, this function does nothing.
void confine_helper();
// Confines this process: from now on, it can read the files below `folder`, but open no other
// files. Sockets are not restricted. Call confine_helper() later; it also ends the access to
// `folder`. Without Landlock in the kernel, and in sanitiser builds, this function does nothing.
void confine_helper_to(const std::filesystem::path& folder);

}  // namespace kibori
