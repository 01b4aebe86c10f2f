// SPDX-License-Identifier: MIT
// The half-space, for scenes, cuts and tests. The studio does not offer it, because it is
// infinite.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct HalfSpace {
  static constexpr const char* kShape = "halfspace";
  static constexpr const char* kAbout =
      "everything behind the plane through the tip normal to the axis";
  static constexpr bool kIsConvex = true;

  static void for_numbers(auto&, auto&&) {}
  bool operator==(const HalfSpace&) const = default;

  void check(ToolCheck&) const {}
  double reach_mm() const { return std::numeric_limits<double>::infinity(); }
  void add_parts(SweptParts& parts) const {
    const Vec3 everywhere = Vec3::Constant(std::numeric_limits<double>::infinity());
    ConvexBody body;
    body.add_plane(Vec3(0, 0, 1), 0);
    body.local_bounds = {-everywhere, everywhere};
    parts.convex(body);
  }
};

}  // namespace kibori
