// SPDX-License-Identifier: MIT
// Converts a grey picture into a relief to carve.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

struct ReliefSize {
  double width_mm = 80;  // along x; the size along y follows from the picture's shape
  double height_mm = 5;  // of white above black
  double base_mm = 3;    // of black above the floor
  bool invert = false;   // black is higher than white
};

// A closed mesh with its lower corner at the origin. The picture's pixels are points of its upper
// side, the first row at the far y. Pixels finer than half of `pitch_mm`, or beyond four million,
// are averaged. Errors: those of reading the picture and of make_lattice; less than 2 pixels per
// side.
Result<TriangleMesh> read_relief(const std::filesystem::path& picture, const ReliefSize& size,
                                 double pitch_mm);

}  // namespace kibori
