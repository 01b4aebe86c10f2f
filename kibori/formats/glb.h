// SPDX-License-Identifier: MIT
// The GLB reader (binary glTF 2.0). Writing: see surface_file.h. Internal to `formats` and
// kibori-import.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The triangles of the default scene [mm, z up]: the file has metres and y up. Reads triangle
// lists, strips and fans, sparse accessors, data URIs and KHR_mesh_quantization. Also accepts the
// JSON alone, if its buffers are data URIs, and files whose chunks are not padded. Required
// extensions that only affect the appearance are ignored. Any other required extension is an error.
// `name` is for messages; `notes` receives what was left out. Errors (with the node, mesh, accessor
// or view): other versions, data in other files, compressed data, ranges that the bytes contradict.
Result<TriangleMesh> parse_glb(std::string_view bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
