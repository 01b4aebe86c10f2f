// SPDX-License-Identifier: MIT
// A cylinder with round ends. Its sweep is the hull of four capsules and the slab between them. Two
// capsules are along its axis, one at each pose. Two are along the motion, one at each end.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Capsule {
  static constexpr const char* kShape = "capsule";
  static constexpr const char* kAbout = "a cylinder with round ends, `length` from tip to end";
  static constexpr bool kIsConvex = true;

  double radius = 3, length = 20;
  static void for_numbers(auto& tool, auto&& f) {
    f("radius", tool.radius);
    f("length", tool.length);
  }
  bool operator==(const Capsule&) const = default;

  void check(ToolCheck& checks) const {
    checks.require(length >= 2 * radius, "length must be at least twice the radius");
  }
  double reach_mm() const { return length; }
  void add_parts(SweptParts& parts) const;
};

}  // namespace kibori
