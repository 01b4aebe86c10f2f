// SPDX-License-Identifier: MIT
// Converts a grey picture into the mesh of a relief.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

struct ReliefSize {
  double width_mm = 80;  // along x; the size along y follows from the picture's shape
  double height_mm = 5;  // from the lowest shade to the highest
  double base_mm = 3;    // from the floor to the lowest shade
  bool invert = false;   // false: white is highest; true: black is highest
};

// Makes a closed mesh with its lower corner at the origin. Each pixel is a point of its upper side.
// The first row of pixels has the largest y. If pixels are smaller than half of `pitch_mm`, or more
// than four million, neighbours are averaged. Errors: those of reading the picture and of
// make_lattice; fewer than 2 pixels per side.
Result<TriangleMesh> read_relief(const std::filesystem::path& picture, const ReliefSize& size,
                                 double pitch_mm);

}  // namespace kibori
