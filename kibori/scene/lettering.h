// SPDX-License-Identifier: MIT
// Converts text in an installed font into a solid, for stamps and stencils of letters.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

struct Lettering {
  std::string text;  // UTF-8; a newline begins another line
  // A family known to fontconfig, with its options ("DejaVu Serif:bold"), or the path of a font
  // file.
  std::string font = "DejaVu Sans";
  double height_mm = 10;  // of a capital H
  double depth_mm = 10;   // length of the extrusion
  // maximum distance between a chord and its curve; 0: 1/1000 of the height
  double tolerance_mm = 0;
};

inline constexpr size_t kMaxLetters = 200;

// A closed mesh: x along the lines, y up, its centre at the origin, z from 0 to depth_mm. Errors: a
// font that is not installed or not readable; a letter that the font lacks; no letters or too many;
// a height or depth outside 0.1 to 1000 mm.
Result<TriangleMesh> letter_mesh(const Lettering& lettering);

// The installed families with outlines, in alphabetical order.
std::vector<std::string> font_families();

}  // namespace kibori
