// SPDX-License-Identifier: MIT
// Converts text in an installed font into a solid, for stamps and stencils of letters.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

struct Lettering {
  std::string text;  // UTF-8; a newline begins the next line
  // A fontconfig name: a family, and options after a colon ("DejaVu Serif:bold"). A text with a
  // slash is the path of a font file.
  std::string font = "DejaVu Sans";
  double height_mm = 10;  // of a capital H
  double depth_mm = 10;   // length of the extrusion
  // Maximum distance between a chord and its curve. Values below 1/1000 of the height count as
  // 1/1000 of the height.
  double tolerance_mm = 0;
};

inline constexpr size_t kMaxLetters = 200;

// Makes a closed mesh: x along the lines, y up, z from 0 to depth_mm. In x and y, the centre of its
// bounds is the origin. Errors: a font that is not installed or not readable; a letter that the
// font lacks; no letters or too many; a text that is not UTF-8; outlines with too many points; a
// height or depth outside 0.1 to 1000 mm.
Result<TriangleMesh> letter_mesh(const Lettering& lettering);

// The installed families with outlines, in alphabetical order.
std::vector<std::string> font_families();

}  // namespace kibori
