// SPDX-License-Identifier: MIT
// The force on a cutter with teeth, from the volume that the cutter removes. The law is Kienzle's
// law for the mean thickness of a tooth's chip:
//
//   section      S = volume / path         a_p: depth along the tool's axis; width a_e = S / a_p
//   engagement   phi = acos(1 - 2 a_e/D)   from the edge of the cut, up or down milling
//   mean chip    h = f_z (2 a_e/D) / phi   f_z: feed per tooth
//   plunge       h = f_z                   along the axis
//   resistance   k_c = k h^(-m)            [N/mm^2], h in mm
//   power        P = k_c Q                 Q: volume per time
//   force        F = P / v_c               mean force along the teeth's path, v_c = pi D n
//
// If the middle of the cutter cuts (face milling), the chip is thicker than this formula says. D is
// the diameter of the cutter. For a ball or a cone, it is the largest one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <kibori/geometry/material.h>

namespace kibori {

// A piece of a path within material.
struct CutPiece {
  double volume_mm3 = 0, path_mm = 0, seconds = 0;
  double depth_mm = 0;   // height of the removed volume along the tool's axis
  bool plunges = false;  // the tool moves mostly along its axis
};

// The tool and the state of the spindle.
struct CutterDrive {
  double diameter_mm = 0;
  int teeth = 0;
  double rpm = 0;
};

struct Engagement {
  double section_mm2 = 0, depth_mm = 0, width_mm = 0;
  double angle_rad = 0;          // engaged part of the circumference
  double feed_per_tooth_mm = 0;  // 0: unknown
  double chip_mm = 0;            // mean thickness of the chip; 0: unknown
  double removal_mm3_s = 0;
};

struct CuttingForce {
  double resistance_n_mm2 = 0, force_n = 0, power_w = 0;
};

// Minimum thickness of a chip in the law [mm]. With a thinner chip, the edge only rubs. Without a
// minimum, the power law would give forces without a limit.
inline constexpr double kMinChip = 0.001;

// Computes the engagement. All values are zero if the piece removes nothing.
Engagement engagement_of(const CutPiece& piece, const CutterDrive& drive);
// Returns nothing if the teeth, the spindle's speed or the material's law are unknown.
std::optional<CuttingForce> cutting_force(const Engagement& engagement, const CutterDrive& drive,
                                          const Material& material);

// Returns the factor for the feed rate that multiplies force and power by `ratio`, at the same
// engagement. (F and P are proportional to f h^(-m), and h is proportional to the feed rate f.)
double feed_factor_for(double ratio, const Engagement& engagement, const Material& material);

// Returns a material for milling: one of haptics/materials.h, or a metal. Null if the name is
// unknown.
const Material* machining_material(const std::string& name);
// Returns the names of all these materials, the metals first.
std::vector<std::string> machining_materials();

}  // namespace kibori
