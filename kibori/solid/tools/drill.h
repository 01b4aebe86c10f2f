// SPDX-License-Identifier: MIT
// The twist drill: a Cone with the point angle of a drill.
#pragma once

#include <kibori/solid/tools/cone.h>
#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Drill {
  static constexpr const char* kShape = "drill";
  static constexpr const char* kAbout =
      "a twist drill, a V cutter with the point angle of a drill (often 118)";
  static constexpr bool kIsConvex = true;

  double angle_deg = 118, radius = 2, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("angle_deg", tool.angle_deg);
    f("radius", tool.radius);
    f("length", tool.length);
  }
  bool operator==(const Drill&) const = default;

  void check(ToolCheck& checks) const { as_cone().check(checks); }
  double reach_mm() const { return as_cone().reach_mm(); }
  void add_parts(SweptParts& parts) const { as_cone().add_parts(parts); }

 private:
  Cone as_cone() const { return {angle_deg, radius, length}; }
};

}  // namespace kibori
