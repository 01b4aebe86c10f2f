// SPDX-License-Identifier: MIT
#include "apps/studio/tool_message.h"

#include <variant>

namespace kibori::studio {

Result<Tool> tool_of(const ChooseTool& chosen) {
  switch (chosen.shape) {
    case 0:
      return Tool(BallTool{chosen.size});
    case 1:
      return Tool(Finger{chosen.size, chosen.length});
    case 2:
      return Tool(Flat{chosen.size, chosen.length});
    case 3:
      return Tool(Capsule{chosen.size, chosen.length});
    case 4:
      return Tool(Bull{chosen.size, chosen.other, chosen.length});
    case 5:
      return Tool(Cone{chosen.other, chosen.size, chosen.length});
    case 6:
      return Tool(BoxTool{Vec3(chosen.size, chosen.length, chosen.other)});
    case 7:
      return Tool(Ellipsoid{Vec3(chosen.size, chosen.length, chosen.other)});
    default:
      return Error{"there is no such tool"};
  }
}

namespace {
struct Shown {
  ShowTool operator()(const BallTool& t) const { return {0, t.radius, 0, 0}; }
  ShowTool operator()(const Finger& t) const { return {1, t.ks, t.length, 0}; }
  ShowTool operator()(const Flat& t) const { return {2, t.radius, t.length, 0}; }
  ShowTool operator()(const Capsule& t) const { return {3, t.radius, t.length, 0}; }
  ShowTool operator()(const Bull& t) const { return {4, t.radius, t.length, t.corner}; }
  ShowTool operator()(const Cone& t) const { return {5, t.radius, t.length, t.angle_deg}; }
  ShowTool operator()(const BoxTool& t) const { return {6, t.size.x(), t.size.y(), t.size.z()}; }
  ShowTool operator()(const Ellipsoid& t) const { return {7, t.radii.x(), t.radii.y(), t.radii.z()}; }
  // Of scenes only: no page can choose or draw these.
  ShowTool operator()(const HalfSpace&) const { return {255, 0, 0, 0}; }
  ShowTool operator()(const MeshTool&) const { return {255, 0, 0, 0}; }
};

}  // namespace

ShowTool shown_as(const Tool& tool) { return std::visit(Shown{}, tool); }

}  // namespace kibori::studio
