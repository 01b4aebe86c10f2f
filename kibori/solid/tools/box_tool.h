// SPDX-License-Identifier: MIT
// The box: its lower face is centred on the tip.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct BoxTool {
  static constexpr const char* kShape = "box";
  static constexpr const char* kAbout = "a box whose lower face is centred on the tip";
  static constexpr bool kIsConvex = true;

  Vec3 size = Vec3(10, 10, 10);
  static void for_numbers(auto& tool, auto&& f) { f("size", tool.size); }
  bool operator==(const BoxTool& other) const { return size == other.size; }

  void check(ToolCheck&) const {}
  double reach_mm() const { return Vec3(size.x() / 2, size.y() / 2, size.z()).norm(); }
  void add_parts(SweptParts& parts) const;
};

}  // namespace kibori
