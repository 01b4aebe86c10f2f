// SPDX-License-Identifier: MIT
// A carver's gouge. It travels along the local x axis. Its section across that axis is the arc of
// its sweep, with everything above the arc between upright walls. As a solid, it is an elliptic
// cylinder under a box.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct Gouge {
  static constexpr const char* kShape = "gouge";
  static constexpr const char* kAbout =
      "a U-gouge, whose edge is the arc of its `sweep`, 2 to 11 as carvers number the roundness";
  static constexpr bool kIsConvex = true;

  double sweep = 7;  // a whole number
  double width = 10, thickness = 1, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("sweep", tool.sweep);
    f("width", tool.width);
    f("thickness", tool.thickness);
    f("length", tool.length);
  }
  bool operator==(const Gouge&) const = default;

  void check(ToolCheck& checks) const {
    checks.require(sweep >= 2 && sweep <= 11 && sweep == std::floor(sweep),
                   "sweep must be a whole number from 2 to 11");
  }
  double reach_mm() const { return Vec3(thickness / 2, width / 2, length).norm(); }
  void add_parts(SweptParts& parts) const;
};

// The arc of a gouge's edge [mm].
struct GougeArc {
  double across, upright;  // half axes of its ellipse; equal for a circle
  double depth;            // the arc has the gouge's width at this depth
};

// Sweeps 2 to 8 are arcs of circles, rounder with each number. Sweep 9 is half a circle. Sweeps 10
// and 11 are half ellipses, deeper than half their width. The gouge must pass check_tool.
GougeArc gouge_arc(const Gouge& gouge);

}  // namespace kibori
