// SPDX-License-Identifier: MIT
// All tool shapes, and the solid that a tool sweeps in a straight motion. Each shape is one file in
// kibori/solid/tools/. tool_shape.h describes the content of such a file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>
#include <variant>

#include <kibori/base/result.h>
#include <kibori/solid/swept_parts.h>
#include <kibori/solid/tool_shape.h>
#include <kibori/solid/tools/ball_tool.h>
#include <kibori/solid/tools/box_tool.h>
#include <kibori/solid/tools/bull.h>
#include <kibori/solid/tools/capsule.h>
#include <kibori/solid/tools/chisel.h>
#include <kibori/solid/tools/cone.h>
#include <kibori/solid/tools/drill.h>
#include <kibori/solid/tools/ellipsoid.h>
#include <kibori/solid/tools/finger.h>
#include <kibori/solid/tools/flat.h>
#include <kibori/solid/tools/gouge.h>
#include <kibori/solid/tools/half_space.h>
#include <kibori/solid/tools/knife.h>
#include <kibori/solid/tools/lollipop.h>
#include <kibori/solid/tools/mesh_tool.h>
#include <kibori/solid/tools/skew.h>
#include <kibori/solid/tools/tapered_ball.h>
#include <kibori/solid/tools/tslot.h>
#include <kibori/solid/tools/vee.h>

namespace kibori {

// All tool shapes. This is the only list.
using Tool =
    std::variant<Finger, BallTool, Flat, Bull, Cone, Capsule, HalfSpace, BoxTool, Ellipsoid,
                 MeshTool, Drill, TaperedBall, Gouge, Vee, Chisel, Skew, Knife, Lollipop, TSlot>;

namespace internal {
template <ToolShape... Shape>
constexpr std::array<const char*, sizeof...(Shape)> shapes_of(
    std::type_identity<std::variant<Shape...>>) {
  return {Shape::kShape...};
}
}  // namespace internal

// The names of all shapes, in the order of Tool. Scenes, documents and messages use them.
inline constexpr auto kToolShapes = internal::shapes_of(std::type_identity<Tool>());

// The name of a tool's shape.
inline const char* shape_of(const Tool& tool) { return kToolShapes[tool.index()]; }

// Returns one line about the tool's shape, for users.
const char* shape_note(const Tool& tool);

// Returns a tool of the named shape with default numbers; nullopt if the name is unknown. A mesh
// tool then has no mesh, and check_tool rejects it.
std::optional<Tool> default_tool(std::string_view shape);

// Calls f(name, number) for each number of a tool, in the order of declaration. A number is a
// double& or, for sizes along x, y and z, a Vec3&. Lengths are in mm, angles in degrees. check_tool
// requires that all numbers are positive.
template <class F>
void for_tool_numbers(Tool& tool, F&& f) {
  std::visit([&](auto& t) { t.for_numbers(t, f); }, tool);
}
template <class F>
void for_tool_numbers(const Tool& tool, F&& f) {
  std::visit([&](const auto& t) { t.for_numbers(t, f); }, tool);
}

// Checks a tool. Error: one sentence that names the invalid parameter.
Status check_tool(const Tool& tool);

// Distance from the tip to the farthest point of the tool [mm]; infinite for a half-space.
double reach_mm(const Tool& tool);

// True if no ray can leave the tool and enter it again.
bool is_convex(const Tool& tool);

// The solid that `tool` sweeps while it moves by motion_mm without turning. Its parts are stored
// inside the object. Only a mesh allocates memory.
class SweptTool final : public Solid {
 public:
  SweptTool(const Tool& tool, const Pose& start, const Vec3& motion_mm, const Lattice& lattice,
            bool start_is_clear = false);

  // Returns a solid that is equal to this one. If the tool has one part, it is that part, which
  // saves an indirection.
  const Solid& solid() const { return parts_.count() == 1 ? parts_[0] : *this; }

  LatticeBox bounds() const override;
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  using Layers = std::array<SpanLayer, SweptParts::kMaxParts>;
  // Returns layer 0 of each part for one tile. Each thread keeps the layers of its last tile,
  // because an edit reads a tile's spans and then its normals.
  Layers& layers_of(const RayTile& rays, bool flip) const;

  // One part, or several parts with at most one interval per ray each. If the union of the parts is
  // convex (convex_), its interval is the hull of their intervals. Otherwise, intervals that touch
  // are merged.
  SweptParts parts_;
  bool convex_;
  uint64_t id_;  // unique for each object
};

}  // namespace kibori
