// SPDX-License-Identifier: MIT
// What a reshaping hand holds: a ball of influence that fades towards its rim; and what a dab of it
// did.
#pragma once

#include <cstdint>

#include <kibori/base/result.h>

namespace kibori {

// How a brush fades from its centre (1) to its rim (0).
enum class Falloff { smooth, linear, constant };

struct Brush {
  double radius_mm = 5;
  double strength = 0.5;  // 0..1; inflate takes -1..1, and below 0 it deflates
  Falloff falloff = Falloff::smooth;
  // Width of the smoothing filter (standard deviation) [mm]; 0: an eighth of the radius. A dab
  // takes at most kMaxSigmaCells.
  double sigma_mm = 0;
  bool keep_volume = false;  // smooth only: what is lost at peaks comes back over the brush
};

inline constexpr double kMaxSigmaCells = 4;

// `distance`: from the brush's centre, in radii. Smooth: (1 - d^2)^2; linear: 1 - d; constant: 1.
// Nothing at 1 and beyond.
inline double falloff_weight(Falloff falloff, double distance) {
  if (!(distance < 1)) return 0;
  const double inner = 1 - distance * distance;
  switch (falloff) {
    case Falloff::smooth:
      return inner * inner;
    case Falloff::linear:
      return 1 - distance;
    case Falloff::constant:
      return 1;
  }
  return 0;
}

// What a dab did to the model; volumes are the mean of the three fields.
struct Reshaped {
  double added_mm3 = 0, removed_mm3 = 0;
  int64_t points = 0;  // lattice nodes that changed sides
};

// Whether a brush is one that a dab can take: finite, radius above 0, strength and sigma in range.
Status check_brush(const Brush& brush);

}  // namespace kibori
