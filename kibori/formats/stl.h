// SPDX-License-Identifier: MIT
// Reads binary and ASCII STL files. surface_file.h writes them. Internal to `formats`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// Parses an STL file. The content decides whether the file is text, because many binary files also
// begin with "solid". ASCII files may have a byte order mark, upper and lower case, any line ends,
// and names of any length. Lines may break between any two words. In a binary file, each triangle
// ends with a 2-byte attribute. If the attribute is the length of more data, this data is skipped.
// `name` is the file's name in messages. `notes` receives sentences about what was left out. Errors
// (with the byte or the line): the count does not fit the file's size; a word should be a number; a
// number is not finite; the file ends too early.
Result<TriangleMesh> parse_stl(std::string_view bytes, const std::string& name,
                               std::vector<std::string>* notes = nullptr);

}  // namespace kibori
