// SPDX-License-Identifier: MIT
// Stamps: a text, a picture or a mesh as a tool that is pressed into the wood.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/scene/lettering.h>
#include <kibori/solid/tool.h>

namespace kibori {

// The most triangles a stamp has: what a tick of the servo can sweep.
inline constexpr size_t kMaxStampTriangles = 20'000;

// All stand on their lowest place, the tip, in the middle of their width and depth. Pressed into a
// top that one looks down on, texts and pictures read as they should.

// The letters, extruded from the tip upwards by their depth, as true to their font as pitch_mm can
// tell. Errors: those of letter_mesh.
Result<Tool> text_stamp(Lettering lettering, double pitch_mm);

struct PictureStamp {
  double width_mm = 20;  // of the picture; its other side follows
  double depth_mm = 2;   // how much deeper white goes than black
  double back_mm = 8;    // of the plate behind
  bool invert = false;   // black goes deepest
};
// A grey picture as a relief: white is deepest. Resolved as finely as pitch_mm asks for and
// kMaxStampTriangles allows. Errors: those of read_relief.
Result<Tool> picture_stamp(const std::filesystem::path& picture, const PictureStamp& size,
                           double pitch_mm);

// A mesh, scaled so that the longer of its sides across is width_mm; 0: as it is. Errors: those of
// read_mesh, no closed solid, too many triangles.
Result<Tool> mesh_stamp(const std::filesystem::path& file, double width_mm);

}  // namespace kibori
