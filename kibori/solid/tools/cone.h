// SPDX-License-Identifier: MIT
// The V cutter: a cone, and a cylinder above it.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Cone {
  static constexpr const char* kShape = "cone";
  static constexpr const char* kAbout =
      "a V cutter, a cone of full angle `angle_deg` up to `radius` and a cylinder from there";
  static constexpr bool kIsConvex = true;

  double angle_deg = 60, radius = 5, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("angle_deg", tool.angle_deg);
    f("radius", tool.radius);
    f("length", tool.length);
  }
  bool operator==(const Cone&) const = default;

  void check(ToolCheck& checks) const { checks.between("angle_deg", angle_deg, 1, 175); }
  double reach_mm() const { return std::hypot(length, radius); }
  void add_parts(SweptParts& parts) const {
    const SinCos half = half_angle(angle_deg);
    const double full = std::min(radius / (half.sin / half.cos), length);
    parts.cone(angle_deg, 0, 0, full);
    parts.cylinder(radius, full, length);
  }
};

}  // namespace kibori
