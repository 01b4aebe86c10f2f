// SPDX-License-Identifier: MIT
// Reads glTF 2.0: binary files (.glb), and JSON files (.gltf) whose data is in data URIs or in
// other files. surface_file.h writes .glb. Internal to `formats` and kibori-import.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Contents of the files that the buffers of a .gltf file name. The key is the URI, as in the file.
// An Error holds the end of a message. parse_glb puts the name of the buffer before it.
using GltfFiles = std::map<std::string, Result<std::vector<char>>>;

// Reads the files that the buffers of the .gltf file `path` name. `bytes` is its text. The files
// must be below the folder of `path`. Absolute paths, `..`, links that lead out of the folder and
// URLs become errors in the map. The map is empty if the text is not JSON.
GltfFiles read_gltf_files(std::string_view bytes, const std::filesystem::path& path);

// Returns the triangles of the default scene in mm with z up. The file is in metres with y up.
// Reads triangle lists, strips and fans, sparse accessors, data URIs and KHR_mesh_quantization.
// Also accepts the JSON alone, and files whose chunks are not padded. Required extensions that
// change no triangle are ignored. Any other required extension is an error that names it. `name` is
// for messages; `notes` receives what was left out. `files`: the result of read_gltf_files. If it
// is null, data in other files is an error. Other errors (with the node, mesh, accessor or view):
// other versions, compressed data, ranges that exceed the data.
Result<TriangleMesh> parse_glb(std::string_view bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr,
                               const GltfFiles* files = nullptr);

}  // namespace kibori
