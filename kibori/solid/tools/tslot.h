// SPDX-License-Identifier: MIT
// The T-slot cutter: a disc on a thin neck.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct TSlot {
  static constexpr const char* kShape = "tslot";
  static constexpr const char* kAbout =
      "a disc on a thin neck, for slots; `neck` and `shank` are radii, and the neck ends at the "
      "height "
      "`reach`";
  static constexpr bool kIsConvex = false;

  double radius = 6, height = 3, neck = 2.5, reach = 20, shank = 3, length = 40;
  static void for_numbers(auto& tool, auto&& f) {
    f("radius", tool.radius);
    f("height", tool.height);
    f("neck", tool.neck);
    f("reach", tool.reach);
    f("shank", tool.shank);
    f("length", tool.length);
  }
  bool operator==(const TSlot&) const = default;

  void check(ToolCheck& checks) const {
    checks.check_max("neck", neck, "radius", radius);
    checks.check_max("neck", neck, "shank", shank);
    checks.require(reach >= height, "reach must be at least the height of the head");
    checks.require(length >= reach, "length must be at least reach");
  }
  double reach_mm() const { return std::hypot(length, std::max(shank, radius)); }
  void add_parts(SweptParts& parts) const {
    parts.cylinder(radius, 0, height);
    // The neck starts within the head, so that no ray finds a gap between the two.
    parts.cylinder(neck, height / 2, length);
    parts.cylinder(shank, reach, length);
  }
};

}  // namespace kibori
