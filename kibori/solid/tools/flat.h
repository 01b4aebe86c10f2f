// SPDX-License-Identifier: MIT
// The flat end mill: a cylinder whose lower face is centred on the tip.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Flat {
  static constexpr const char* kShape = "flat";
  static constexpr const char* kAbout = "a flat end mill, a cylinder that stands on its tip";
  static constexpr bool kIsConvex = true;

  double radius = 3, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("radius", tool.radius);
    f("length", tool.length);
  }
  bool operator==(const Flat&) const = default;

  void check(ToolCheck&) const {}
  double reach_mm() const { return std::hypot(length, radius); }
  void add_parts(SweptParts& parts) const { parts.cylinder(radius, 0, length); }
};

}  // namespace kibori
