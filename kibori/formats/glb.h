// SPDX-License-Identifier: MIT
// Reads glTF 2.0: binary files (.glb), and JSON files (.gltf). The data of a .gltf file is in data
// URIs or in other files. surface_file.h writes .glb. Internal to `formats` and kibori-import.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The contents of the other files that the buffers of a .gltf file name. The key is the URI as in
// the file. If a file was not read, the value is an Error with the end of a message. parse_glb puts
// the name of the buffer before it.
using GltfFiles = std::map<std::string, Result<std::vector<char>>>;

// Reads the files that the buffers of a .gltf file name. `path` is the .gltf file, and `bytes` its
// text. The files must be below the folder of `path`. If a name is an absolute path or a URL,
// contains `..`, or is a link out of the folder, its value is an Error. The result is empty if
// `bytes` is not JSON.
GltfFiles read_gltf_files(std::string_view bytes, const std::filesystem::path& path);

// Parses a glTF file. Returns the triangles of the default scene in mm with z up. (In the file,
// they are in metres with y up.) Reads triangle lists, strips and fans, sparse accessors, data URIs
// and KHR_mesh_quantization. Also accepts the JSON alone, and files whose chunks are not padded.
// `name` is the file's name in messages. `notes` receives sentences about what was left out.
// `files` is the result of read_gltf_files, or null. Errors (with the node, mesh, accessor or
// view): the version is not 2; the mesh is compressed; a range exceeds the data; data is in another
// file and `files` is null; the file requires an extension that changes triangles and is not
// supported.
Result<TriangleMesh> parse_glb(std::string_view bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr,
                               const GltfFiles* files = nullptr);

}  // namespace kibori
