// SPDX-License-Identifier: MIT
// The tapered ball nose: a ball, a cone whose side touches the ball in a circle, and a cylinder.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct TaperedBall {
  static constexpr const char* kShape = "tapered";
  static constexpr const char* kAbout =
      "a tapered ball nose: a ball of radius `ball`, then a cone of full angle `angle_deg` up to "
      "`radius`, then a cylinder. The cone touches the ball all round";
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
    checks.check_max("ball", ball, "radius", radius);
    checks.require(length >= 2 * ball, "length must be at least twice the ball's radius");
  }
  double reach_mm() const { return std::hypot(length, radius); }
  void add_parts(SweptParts& parts) const {
    const SinCos half = half_angle(angle_deg);
    // Heights of three places:
    // - the apex of the whole cone, below the tip,
    // - the circle in which ball and cone touch,
    // - the place where the cone is as wide as the cylinder.
    const double apex = ball - ball / half.sin, tangent = ball - ball * half.sin,
                 full = std::min(apex + radius * half.cos / half.sin, length);
    parts.ball(ball);
    parts.cone(angle_deg, apex, tangent, full);
    parts.cylinder(radius, full, length);
  }
};

}  // namespace kibori
