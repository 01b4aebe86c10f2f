// SPDX-License-Identifier: MIT
// The STL reader, for binary and ASCII files. Writing: see surface_file.h. Internal to `formats`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The content decides whether a file is text, not its first five bytes: many binary files begin
// with "solid". ASCII files may have a byte order mark, any case, line ends and line breaks, and
// names of any length. Attributes of binary files may have payloads: two bytes after each triangle
// are their length. `name` is for messages; `notes` receives what was left out. Errors (with byte
// or line): counts that the bytes contradict, words where numbers should be, numbers that are not
// finite, a file without its end.
Result<TriangleMesh> parse_stl(std::string_view bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
