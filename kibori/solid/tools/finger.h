// SPDX-License-Identifier: MIT
// The virtual finger of the original paper (eq. 1, docs/paper.md): a paraboloid.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Finger {
  static constexpr const char* kShape = "finger";
  static constexpr const char* kAbout =
      "the paper's virtual finger, inside where z > `ks` (x² + y²), with `ks` in 1/mm";
  static constexpr bool kIsConvex = true;

  double ks = 0.1;  // [1/mm]
  double length = 40;
  static void for_numbers(auto& tool, auto&& f) {
    f("ks", tool.ks);
    f("length", tool.length);
  }
  bool operator==(const Finger&) const = default;

  void check(ToolCheck&) const {}
  double reach_mm() const { return std::hypot(length, std::sqrt(length / ks)); }
  void add_parts(SweptParts& parts) const;
};

}  // namespace kibori
