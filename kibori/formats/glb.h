// SPDX-License-Identifier: MIT
// The reader of glTF 2.0: binary (.glb), and text with its data in other files (.gltf). Writing: see
// surface_file.h. Internal to `formats` and kibori-import.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The contents of the files that buffers name, by URI. An error is the end of a sentence that begins
// with the buffer.
using GltfFiles = std::map<std::string, Result<std::vector<char>>>;

// Reads the files that the buffers of the .gltf file `path` name. `bytes` is its text. A name must
// stay in the folder of `path`: absolute paths, `..`, links that lead out of it and URLs become
// errors. Text that is not JSON names no files.
GltfFiles read_gltf_files(std::string_view bytes, const std::filesystem::path& path);

// The triangles of the default scene [mm, z up]: the file has metres and y up. Reads triangle
// lists, strips and fans, sparse accessors, data URIs and KHR_mesh_quantization. Also accepts the
// JSON alone, and files whose chunks are not padded. Required extensions that only concern the look
// are ignored; any other is an error that names it. `name` is for messages; `notes` receives what
// was left out. `files` holds data in other files; null: such data is refused. Errors (with the
// node, mesh, accessor or view): other versions, data in other files, compressed data, ranges that
// the bytes contradict.
Result<TriangleMesh> parse_glb(std::string_view bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr,
                               const GltfFiles* files = nullptr);

}  // namespace kibori
