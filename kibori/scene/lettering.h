// SPDX-License-Identifier: MIT
// Text in an installed font as a solid: what a stamp or a stencil of letters is made of.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

struct Lettering {
  std::string text;  // UTF-8; a newline begins another line
  // A family, as fontconfig knows it, and what else it understands ("DejaVu Serif:bold"), or the
  // path of a font's file.
  std::string font = "DejaVu Sans";
  double height_mm = 10;    // of a capital H
  double depth_mm = 10;     // how far it is extruded
  double tolerance_mm = 0;  // how far a chord may be from its curve; 0: 1/1000 of the height
};

inline constexpr size_t kMaxLetters = 200;

// A closed mesh: x along the lines, y up, the middle of it all at the origin, z from 0 to depth_mm.
// Errors: a font that is not installed or cannot be read, a letter it does not have, no letters at
// all or too many, heights or depths beyond 0.1 to 1000 mm.
Result<TriangleMesh> letter_mesh(const Lettering& lettering);

// The families that are installed and can be outlined, in alphabetical order.
std::vector<std::string> font_families();

}  // namespace kibori
