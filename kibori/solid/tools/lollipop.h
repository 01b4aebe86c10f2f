// SPDX-License-Identifier: MIT
// The lollipop cutter, for undercuts: a ball on a thin neck.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Lollipop {
  static constexpr const char* kShape = "lollipop";
  static constexpr const char* kAbout =
      "a ball on a thin neck, for undercuts; `neck` and `shank` are radii, and the neck ends at "
      "the "
      "height `reach`";
  static constexpr bool kIsConvex = false;

  double radius = 4, neck = 2, reach = 20, shank = 3, length = 40;
  static void for_numbers(auto& tool, auto&& f) {
    f("radius", tool.radius);
    f("neck", tool.neck);
    f("reach", tool.reach);
    f("shank", tool.shank);
    f("length", tool.length);
  }
  bool operator==(const Lollipop&) const = default;

  void check(ToolCheck& checks) const {
    checks.check_max("neck", neck, "radius", radius);
    checks.check_max("neck", neck, "shank", shank);
    checks.require(reach >= 2 * radius, "reach must be at least the height of the head");
    checks.require(length >= reach, "length must be at least reach");
  }
  double reach_mm() const { return std::hypot(length, std::max(shank, radius)); }
  void add_parts(SweptParts& parts) const {
    parts.ball(radius);
    // The neck starts within the head, so that no ray finds a gap between the two.
    parts.cylinder(neck, radius, length);
    parts.cylinder(shank, reach, length);
  }
};

}  // namespace kibori
