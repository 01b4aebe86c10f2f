// SPDX-License-Identifier: MIT
// The skew chisel: its tip is a corner, from which its edge rises along the local y axis.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Skew {
  static constexpr const char* kShape = "skew";
  static constexpr const char* kAbout =
      "a skew chisel, whose edge rises by `skew_deg` from the tip, its corner";
  static constexpr bool kIsConvex = true;

  double width = 12, skew_deg = 30, bevel_deg = 25, thickness = 3, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("width", tool.width);
    f("skew_deg", tool.skew_deg);
    f("bevel_deg", tool.bevel_deg);
    f("thickness", tool.thickness);
    f("length", tool.length);
  }
  bool operator==(const Skew&) const = default;

  void check(ToolCheck& checks) const;
  double reach_mm() const { return Vec3(thickness / 2, width, length).norm(); }
  void add_parts(SweptParts& parts) const;
};

}  // namespace kibori
