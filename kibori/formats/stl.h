// SPDX-License-Identifier: MIT
// Reads binary and ASCII STL files. surface_file.h writes them. Internal to `formats`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The content decides whether a file is text, not its first five bytes: many binary files begin
// with "solid". ASCII files may have a byte order mark, upper and lower case, any line ends, and
// names of any length. Lines may break between any two words. In a binary file, each triangle ends
// with a 2-byte attribute. It may be the length of further data, which follows the triangle and is
// skipped. `name` is for messages; `notes` receives what was left out. Errors (with byte or line):
// a count that does not fit the file's size, words where numbers should be, numbers that are not
// finite. Also a file that ends too early.
Result<TriangleMesh> parse_stl(std::string_view bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
