// SPDX-License-Identifier: MIT
// The flat carving chisel: its edge is along the local y axis.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Chisel {
  static constexpr const char* kShape = "chisel";
  static constexpr const char* kAbout =
      "a flat chisel, with bevels of full angle `bevel_deg` on both sides up to `thickness`";
  static constexpr bool kIsConvex = true;

  double width = 12, bevel_deg = 25, thickness = 3, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("width", tool.width);
    f("bevel_deg", tool.bevel_deg);
    f("thickness", tool.thickness);
    f("length", tool.length);
  }
  bool operator==(const Chisel&) const = default;

  void check(ToolCheck& checks) const { checks.between("bevel_deg", bevel_deg, 5, 120); }
  double reach_mm() const { return Vec3(thickness / 2, width / 2, length).norm(); }
  void add_parts(SweptParts& parts) const {
    parts.wedge_blade(1, bevel_deg, thickness, width, length);
  }
};

}  // namespace kibori
