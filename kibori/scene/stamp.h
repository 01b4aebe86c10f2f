// SPDX-License-Identifier: MIT
// Stamps: a text, a picture or a mesh as a tool that is pressed into the wood.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/scene/lettering.h>
#include <kibori/solid/tool.h>

namespace kibori {

// Maximum number of triangles of a stamp: what a tick of the servo can sweep.
inline constexpr size_t kMaxStampTriangles = 20'000;

// The tip of a stamp is its lowest point, in the middle of its width and depth. If pressed into a
// top that one looks down on, texts and pictures are not mirrored.

// Letters, extruded from the tip upwards by their depth. `pitch_mm` sets the accuracy of the
// outlines. Errors: those of letter_mesh.
Result<Tool> text_stamp(Lettering lettering, double pitch_mm);

struct PictureStamp {
  double width_mm = 20;  // of the picture; its other side follows
  double depth_mm = 2;   // depth of white below black
  double back_mm = 8;    // thickness of the plate behind
  bool invert = false;   // black is deepest
};
// A grey picture as a relief; white is deepest. The resolution follows from pitch_mm and
// kMaxStampTriangles. Errors: those of read_relief.
Result<Tool> picture_stamp(const std::filesystem::path& picture, const PictureStamp& size,
                           double pitch_mm);

// A mesh, scaled so that the longer of its sides across is width_mm; 0: not scaled. Errors: those
// of read_mesh; not a closed solid; too many triangles.
Result<Tool> mesh_stamp(const std::filesystem::path& file, double width_mm);

}  // namespace kibori
