// SPDX-License-Identifier: MIT
// A cylinder with round ends. It sweeps the hull of four capsules, along its axis at both poses and
// along the motion at both ends, and of the slab between them.
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
  FlatFaces flat_faces() const { return {}; }
  void add_parts(SweptParts& parts) const;
};

}  // namespace kibori
