// SPDX-License-Identifier: MIT
// Converts text in an installed font into a closed mesh, for stamps and stencils of letters.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

struct Lettering {
  std::string text;  // UTF-8; a newline begins a new line
  // The name of a font for fontconfig: a family, with options after a colon ("DejaVu Serif:bold").
  // A name with a slash is the path of a font file.
  std::string font = "DejaVu Sans";
  double height_mm = 10;  // height of a capital H
  double depth_mm = 10;   // length of the extrusion
  // Maximum distance between a curve of an outline and its chords. Values below 1/1000 of height_mm
  // count as 1/1000 of height_mm.
  double tolerance_mm = 0;
};

inline constexpr size_t kMaxLetters = 200;

// Makes a closed mesh of the text. x is along the lines, and y up. z goes from 0 to depth_mm. In x
// and y, the centre of the mesh's bounds is the origin. Errors: the font is not installed or cannot
// be read; the font lacks a letter; the text has no letters, or more than kMaxLetters; the text is
// not UTF-8; the outlines have too many points; height or depth is outside 0.1 to 1000 mm.
Result<TriangleMesh> letter_mesh(const Lettering& lettering);

// Returns the installed font families with outlines, in alphabetical order.
std::vector<std::string> font_families();

}  // namespace kibori
