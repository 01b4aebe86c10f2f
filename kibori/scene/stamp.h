// SPDX-License-Identifier: MIT
// Stamps: a text, a picture or a mesh as a tool that is pressed into the wood.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/scene/lettering.h>
#include <kibori/solid/tool.h>

namespace kibori {

// Maximum number of triangles of a stamp. The servo cannot sweep more of them within one tick.
inline constexpr size_t kMaxStampTriangles = 20'000;

// The tip of a stamp is at the height of its lowest point. In x and y it is the middle of the
// stamp's bounds. The imprint of a text or picture, seen from above, is not mirrored.

// Makes a stamp of letters. They extend from the tip upwards by their depth. The outlines are as
// accurate as `pitch_mm` requires. Errors: those of letter_mesh; too many triangles.
Result<Tool> text_stamp(Lettering lettering, double pitch_mm);

struct PictureStamp {
  double width_mm = 20;  // of the picture; its other side follows from this
  double depth_mm = 2;   // depth of the imprint, from the lightest shade to the darkest
  double back_mm = 8;    // thickness of the plate behind the relief
  bool invert = false;   // false: white is deepest; true: black is deepest
};
// Makes a stamp of a grey picture as a relief. Pixels finer than pitch_mm needs are averaged, and
// so are pictures wider than 128 pixels. Errors: those of read_relief; a size outside 0.1 to
// 1000 mm; too many triangles.
Result<Tool> picture_stamp(const std::filesystem::path& picture, const PictureStamp& size,
                           double pitch_mm);

// Makes a stamp of a mesh, scaled so that its longer horizontal side is width_mm. 0: not scaled.
// Errors: those of read_mesh; a mesh that is not closed or has no width; too many triangles.
Result<Tool> mesh_stamp(const std::filesystem::path& file, double width_mm);

}  // namespace kibori
