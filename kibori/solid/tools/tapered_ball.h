// SPDX-License-Identifier: MIT
// Tapered ball nose: the hull of a ball, a cone that touches it all round, and a cylinder.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct TaperedBall {
  static constexpr const char* kShape = "tapered";
  static constexpr const char* kAbout =
      "a tapered ball nose, a ball of radius `ball`, a cone of full angle `angle_deg` that touches "
      "it "
      "all round, up to `radius`, and a cylinder from there";
  static constexpr bool kIsConvex = true;

  double ball = 1, angle_deg = 20, radius = 4, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("ball", tool.ball);
    f("angle_deg", tool.angle_deg);
    f("radius", tool.radius);
    f("length", tool.length);
  }
  bool operator==(const TaperedBall&) const = default;

  void check(ToolCheck& checks) const {
    checks.between("angle_deg", angle_deg, 1, 175);
    checks.at_most("ball", ball, "radius", radius);
    checks.require(length >= 2 * ball, "length must be at least twice the ball's radius");
  }
  double reach_mm() const { return std::hypot(length, radius); }
  FlatFaces flat_faces() const { return {}; }
  void add_parts(SweptParts& parts) const {
    const SinCos half = half_angle(angle_deg);
    // Heights of the whole cone's apex, below the tip, of the circle in which ball and cone touch,
    // and of the place where the cone is as wide as the cylinder.
    const double apex = ball - ball / half.sin, tangent = ball - ball * half.sin,
                 full = std::min(apex + radius * half.cos / half.sin, length);
    parts.ball(ball);
    parts.cone(angle_deg, apex, tangent, full);
    parts.cylinder(radius, full, length);
  }
};

}  // namespace kibori
