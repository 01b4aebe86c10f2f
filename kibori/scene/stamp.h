// SPDX-License-Identifier: MIT
// Stamps: tools in the shape of a text, a picture or a mesh, which are pressed into the wood.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/scene/lettering.h>
#include <kibori/solid/tool.h>

namespace kibori {

// Maximum number of triangles of a stamp. The servo cannot sweep more triangles in one tick.
inline constexpr size_t kMaxStampTriangles = 20'000;

// The tip of a stamp is at the height of the stamp's lowest point, in the middle of its bounds in x
// and y. The imprint of a text or a picture is not mirrored when it is seen from above.

// Makes a stamp of letters. The letters extend from the tip upwards by lettering.depth_mm.
// `pitch_mm` decides how accurate the outlines are. Errors: those of letter_mesh; there are too
// many triangles.
Result<Tool> text_stamp(Lettering lettering, double pitch_mm);

struct PictureStamp {
  double width_mm = 20;  // width of the picture; its other side follows from it
  double depth_mm = 2;   // depth of the imprint from the lightest to the darkest shade
  double back_mm = 8;    // thickness of the plate behind the relief
  bool invert = false;   // false: white is deepest; true: black is deepest
};
// Makes a stamp of a grey picture as a relief. Pixels are averaged if they are finer than
// `pitch_mm` needs, or if the picture is wider than 128 pixels. Errors: those of read_relief; the
// width or the depth is outside 0.1 to 1000 mm; there are too many triangles.
Result<Tool> picture_stamp(const std::filesystem::path& picture, const PictureStamp& size,
                           double pitch_mm);

// Makes a stamp of a mesh, scaled so that its longer horizontal side is `width_mm`. If this is 0,
// the mesh is not scaled. Errors: those of read_mesh; the mesh is not closed or has no width; there
// are too many triangles.
Result<Tool> mesh_stamp(const std::filesystem::path& file, double width_mm);

}  // namespace kibori
