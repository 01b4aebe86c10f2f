// SPDX-License-Identifier: MIT
// Converts a grey picture into the mesh of a relief.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

struct ReliefSize {
  double width_mm = 80;  // size along x; the size along y follows from the picture
  double height_mm = 5;  // height of the highest shade above the lowest
  double base_mm = 3;    // height of the lowest shade above the floor
  bool invert = false;   // false: white is high; true: black is high
};

// Makes a closed mesh with its lower corner at the origin. Each pixel is a point of the upper side.
// The first row of pixels has the largest y. If pixels are smaller than half of `pitch_mm`, or if
// there are more than four million, neighbours are averaged. Errors: the picture cannot be read; a
// side has fewer than 2 pixels; those of make_lattice.
Result<TriangleMesh> read_relief(const std::filesystem::path& picture, const ReliefSize& size,
                                 double pitch_mm);

}  // namespace kibori
