// SPDX-License-Identifier: MIT
// The bull-nose end mill: the hull of a cylinder and of the rounded rim below it.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Bull {
  static constexpr const char* kShape = "bull";
  static constexpr const char* kAbout =
      "a bull-nose end mill, a flat one whose rim is rounded by `corner`";
  static constexpr bool kIsConvex = true;

  double radius = 5, corner = 1, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("radius", tool.radius);
    f("corner", tool.corner);
    f("length", tool.length);
  }
  bool operator==(const Bull&) const = default;

  void check(ToolCheck& checks) const {
    checks.check_max("corner", corner, "radius", radius);
    checks.require(length >= 2 * corner, "length must be at least twice the corner");
  }
  double reach_mm() const { return std::hypot(length, radius); }
  void add_parts(SweptParts& parts) const {
    const double scale = parts.scale(), round = corner * scale;
    // The cylinder is at least as high as the rim. Otherwise the hull would not contain all of
    // the rim.
    const BodyTop top(length * scale, std::max(2 * round, parts.useful()));
    parts.convex(cylinder_body(radius * scale, round, top));
    parts.add<SweptRim>(parts.above_tip(round), parts.frame(), (radius - corner) * scale, round,
                        parts.motion(), parts.start_is_clear());
  }
};

}  // namespace kibori
