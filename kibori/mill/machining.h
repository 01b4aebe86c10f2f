// SPDX-License-Identifier: MIT
// Forces on a cutter with teeth, from the volume that it removes. Kienzle's law with the mean
// thickness of a tooth's chip:
//
//   section      S = volume / path         a_p: depth along the tool's axis; width a_e = S / a_p
//   engagement   phi = acos(1 - 2 a_e/D)   from the edge of the cut, up or down milling
//   mean chip    h = f_z (2 a_e/D) / phi   f_z: feed per tooth
//   plunge       h = f_z                   along the axis
//   resistance   k_c = k h^(-m)            [N/mm^2], h in mm
//   power        P = k_c Q                 Q: volume per time
//   force        F = P / v_c               mean force along the teeth's path, v_c = pi D n
//
// If the middle of the cutter cuts (face milling), the chip is thicker than the formula says. For a
// ball or a cone D is the largest diameter.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <kibori/geometry/material.h>

namespace kibori {

// One piece of a path in material.
struct CutPiece {
  double volume_mm3 = 0, path_mm = 0, seconds = 0;
  double depth_mm = 0;   // of the removed volume along the tool's axis
  bool plunges = false;  // moves mostly along the axis
};

// State of the tool and of the spindle.
struct CutterDrive {
  double diameter_mm = 0;
  int teeth = 0;
  double rpm = 0;
};

struct Engagement {
  double section_mm2 = 0, depth_mm = 0, width_mm = 0;
  double angle_rad = 0;          // of the engaged part of the circumference
  double feed_per_tooth_mm = 0;  // 0: unknown
  double chip_mm = 0;            // mean thickness; 0: unknown
  double removal_mm3_s = 0;
};

struct CuttingForce {
  double resistance_n_mm2 = 0, force_n = 0, power_w = 0;
};

// Minimum thickness of a chip in the law [mm]. An edge rubs if the chip is thinner, and without a
// minimum the power law would have no limit.
inline constexpr double kMinChip = 0.001;

Engagement engagement_of(const CutPiece& piece, const CutterDrive& drive);
// Nothing if teeth, spindle speed or the material's law are unknown.
std::optional<CuttingForce> cutting_force(const Engagement& engagement, const CutterDrive& drive,
                                          const Material& material);

// Factor of the feed rate at which force and power are `ratio` times as large, at the same
// engagement: F and P grow with f h^(-m), and h with f.
double feed_factor_for(double ratio, const Engagement& engagement, const Material& material);

// Materials for milling: those of haptics/materials.h, and metals. Null if the name is unknown.
const Material* machining_material(const std::string& name);
// Names of all materials, the metals first.
std::vector<std::string> machining_materials();

}  // namespace kibori
