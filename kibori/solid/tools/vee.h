// SPDX-License-Identifier: MIT
// The V-gouge, a carver's parting tool: a gouge whose section is a V.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Vee {
  static constexpr const char* kShape = "vee";
  static constexpr const char* kAbout =
      "a V-gouge or parting tool, whose edge is a V of full angle `angle_deg`";
  static constexpr bool kIsConvex = true;

  double angle_deg = 60, width = 8, thickness = 1, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("angle_deg", tool.angle_deg);
    f("width", tool.width);
    f("thickness", tool.thickness);
    f("length", tool.length);
  }
  bool operator==(const Vee&) const = default;

  void check(ToolCheck& checks) const { checks.between("angle_deg", angle_deg, 1, 175); }
  double reach_mm() const { return Vec3(thickness / 2, width / 2, length).norm(); }
  void add_parts(SweptParts& parts) const {
    parts.wedge_blade(0, angle_deg, thickness, width, length);
  }
};

}  // namespace kibori
