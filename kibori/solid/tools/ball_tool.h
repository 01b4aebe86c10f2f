// SPDX-License-Identifier: MIT
// The ball burr: a ball whose lowest point is the tip.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct BallTool {
  static constexpr const char* kShape = "ball";
  static constexpr const char* kAbout = "a ball";
  static constexpr bool kIsConvex = true;

  double radius = 5;
  static void for_numbers(auto& tool, auto&& f) { f("radius", tool.radius); }
  bool operator==(const BallTool&) const = default;

  void check(ToolCheck&) const {}
  double reach_mm() const { return 2 * radius; }
  void add_parts(SweptParts& parts) const { parts.ball(radius); }
};

}  // namespace kibori
