// SPDX-License-Identifier: MIT
// A knife with a spear point: a blade in the local xz plane.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Knife {
  static constexpr const char* kShape = "knife";
  static constexpr const char* kAbout =
      "a spear-point knife, whose two edges of full angle `edge_deg` meet at the tip at the "
      "angle `point_deg`";
  static constexpr bool kIsConvex = true;

  double edge_deg = 20, point_deg = 60, length = 20;
  static void for_numbers(auto& tool, auto&& f) {
    f("edge_deg", tool.edge_deg);
    f("point_deg", tool.point_deg);
    f("length", tool.length);
  }
  bool operator==(const Knife&) const = default;

  void check(ToolCheck& checks) const {
    checks.between("edge_deg", edge_deg, 1, 120);
    checks.between("point_deg", point_deg, 5, 150);
  }
  double reach_mm() const { return length / half_angle(point_deg).cos; }
  void add_parts(SweptParts& parts) const;
};

}  // namespace kibori
