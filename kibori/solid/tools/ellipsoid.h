// SPDX-License-Identifier: MIT
// The ellipsoid: its lowest point is the tip.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Ellipsoid {
  static constexpr const char* kShape = "ellipsoid";
  static constexpr const char* kAbout = "an ellipsoid whose lowest point is the tip";
  static constexpr bool kIsConvex = true;

  Vec3 radii = Vec3(5, 5, 5);
  static void for_numbers(auto& tool, auto&& f) { f("radii", tool.radii); }
  bool operator==(const Ellipsoid& other) const { return radii == other.radii; }

  void check(ToolCheck&) const {}
  double reach_mm() const { return 2 * radii.maxCoeff(); }
  void add_parts(SweptParts& parts) const;
};

}  // namespace kibori
