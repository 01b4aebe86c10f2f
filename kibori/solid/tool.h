// SPDX-License-Identifier: MIT
// Tools: shapes a user can hold, in their own frame (tip at the origin, body along +z, mm), and the
// solid a tool sweeps in a straight motion. Adding a shape: a struct here, with its name and its
// numbers, a place in `Tool`, and its checks, reach and body in tool.cpp (docs/architecture.md,
// "How to add a tool shape").
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <new>
#include <optional>
#include <string_view>
#include <type_traits>
#include <variant>

#include <kibori/base/result.h>
#include <kibori/dexel/field.h>
#include <kibori/geometry/mesh.h>
#include <kibori/solid/ball.h>
#include <kibori/solid/convex.h>
#include <kibori/solid/mesh_solid.h>
#include <kibori/solid/rim.h>

namespace kibori {

// The paper's virtual finger (eq. 1): inside where z - ks (x^2 + y^2) > 0, up to z = length. ks
// [1/mm].
struct Finger {
  static constexpr const char* kShape = "finger";
  double ks = 0.1, length = 40;
  static void for_numbers(auto& tool, auto&& f) {
    f("ks", tool.ks);
    f("length", tool.length);
  }
  bool operator==(const Finger&) const = default;
};

struct BallTool {
  static constexpr const char* kShape = "ball";
  double radius = 5;
  static void for_numbers(auto& tool, auto&& f) { f("radius", tool.radius); }
  bool operator==(const BallTool&) const = default;
};

// Flat end mill: a cylinder that stands on its tip.
struct Flat {
  static constexpr const char* kShape = "flat";
  double radius = 3, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("radius", tool.radius);
    f("length", tool.length);
  }
  bool operator==(const Flat&) const = default;
};

// Bull-nose end mill: a flat whose rim is rounded by `corner` <= radius.
struct Bull {
  static constexpr const char* kShape = "bull";
  double radius = 5, corner = 1, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("radius", tool.radius);
    f("corner", tool.corner);
    f("length", tool.length);
  }
  bool operator==(const Bull&) const = default;
};

// V cutter: a cone of full angle angle_deg up to `radius`, a cylinder from there to `length`.
struct Cone {
  static constexpr const char* kShape = "cone";
  double angle_deg = 60, radius = 5, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("angle_deg", tool.angle_deg);
    f("radius", tool.radius);
    f("length", tool.length);
  }
  bool operator==(const Cone&) const = default;
};

// A cylinder with round ends; `length` from tip to end.
struct Capsule {
  static constexpr const char* kShape = "capsule";
  double radius = 3, length = 20;
  static void for_numbers(auto& tool, auto&& f) {
    f("radius", tool.radius);
    f("length", tool.length);
  }
  bool operator==(const Capsule&) const = default;
};

// Everything on the body's side of the plane through the tip.
struct HalfSpace {
  static constexpr const char* kShape = "halfspace";
  static void for_numbers(auto&, auto&&) {}
  bool operator==(const HalfSpace&) const = default;
};

// A box whose lower face is centred on the tip.
struct BoxTool {
  static constexpr const char* kShape = "box";
  Vec3 size = Vec3(10, 10, 10);
  static void for_numbers(auto& tool, auto&& f) { f("size", tool.size); }
  bool operator==(const BoxTool& other) const { return size == other.size; }
};

// The tip is its lowest point.
struct Ellipsoid {
  static constexpr const char* kShape = "ellipsoid";
  Vec3 radii = Vec3(5, 5, 5);
  static void for_numbers(auto& tool, auto&& f) { f("radii", tool.radii); }
  bool operator==(const Ellipsoid& other) const { return radii == other.radii; }
};

// A closed mesh in tool coordinates. Its numbers are its own; scenes name a file.
struct MeshTool {
  static constexpr const char* kShape = "mesh";
  std::shared_ptr<const TriangleMesh> mesh;
  static void for_numbers(auto&, auto&&) {}
  bool operator==(const MeshTool&) const = default;
};

// Twist drill: a V cutter with the point angle of a drill.
struct Drill {
  static constexpr const char* kShape = "drill";
  double angle_deg = 118, radius = 2, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("angle_deg", tool.angle_deg);
    f("radius", tool.radius);
    f("length", tool.length);
  }
  bool operator==(const Drill&) const = default;
};

// Tapered ball nose: a ball of radius `ball` at the tip, a cone of full angle angle_deg that
// touches it all round, up to `radius`, and a cylinder from there to `length`.
struct TaperedBall {
  static constexpr const char* kShape = "tapered";
  double ball = 1, angle_deg = 20, radius = 4, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("ball", tool.ball);
    f("angle_deg", tool.angle_deg);
    f("radius", tool.radius);
    f("length", tool.length);
  }
  bool operator==(const TaperedBall&) const = default;
};

// A carver's gouge: its section, across the way it leads (its local x axis), is the arc of its
// sweep and everything above that between upright walls. Sweeps 2 to 8 are arcs of circles that get
// rounder, 9 is half a circle, 10 and 11 are half ellipses, deeper than half as wide.
struct Gouge {
  static constexpr const char* kShape = "gouge";
  double sweep = 7, width = 10, thickness = 1, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("sweep", tool.sweep);
    f("width", tool.width);
    f("thickness", tool.thickness);
    f("length", tool.length);
  }
  bool operator==(const Gouge&) const = default;
};

// How deep and how wide the arc of a gouge is, all [mm].
struct GougeArc {
  double across, upright;  // half axes of the ellipse it is of; equal for a circle
  double depth;            // where the arc is as wide as the gouge
};
// Of a gouge that check_tool accepts.
GougeArc gouge_arc(const Gouge& gouge);

// V-gouge, a carver's parting tool: as a gouge, with a V of full angle angle_deg for its section.
struct Vee {
  static constexpr const char* kShape = "vee";
  double angle_deg = 60, width = 8, thickness = 1, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("angle_deg", tool.angle_deg);
    f("width", tool.width);
    f("thickness", tool.thickness);
    f("length", tool.length);
  }
  bool operator==(const Vee&) const = default;
};

// A flat carving chisel: its edge lies along the local y axis, with bevels of full angle bevel_deg
// on both sides up to `thickness`.
struct Chisel {
  static constexpr const char* kShape = "chisel";
  double width = 12, bevel_deg = 25, thickness = 3, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("width", tool.width);
    f("bevel_deg", tool.bevel_deg);
    f("thickness", tool.thickness);
    f("length", tool.length);
  }
  bool operator==(const Chisel&) const = default;
};

// A skew chisel: the edge rises by skew_deg from the tip, its corner, along the local y axis.
struct Skew {
  static constexpr const char* kShape = "skew";
  double width = 12, skew_deg = 30, bevel_deg = 25, thickness = 3, length = 30;
  static void for_numbers(auto& tool, auto&& f) {
    f("width", tool.width);
    f("skew_deg", tool.skew_deg);
    f("bevel_deg", tool.bevel_deg);
    f("thickness", tool.thickness);
    f("length", tool.length);
  }
  bool operator==(const Skew&) const = default;
};

// A knife with a spear point: a blade in the local xz plane, whose two edges of full angle edge_deg
// meet at the tip under the angle point_deg.
struct Knife {
  static constexpr const char* kShape = "knife";
  double edge_deg = 20, point_deg = 60, length = 20;
  static void for_numbers(auto& tool, auto&& f) {
    f("edge_deg", tool.edge_deg);
    f("point_deg", tool.point_deg);
    f("length", tool.length);
  }
  bool operator==(const Knife&) const = default;
};

// Lollipop cutter: a ball on a thin neck, for undercuts. `neck` and `shank` are radii; the neck
// goes up to the height `reach` above the tip, the shank from there to `length`.
struct Lollipop {
  static constexpr const char* kShape = "lollipop";
  double radius = 4, neck = 2, reach = 20, shank = 3, length = 40;
  static void for_numbers(auto& tool, auto&& f) {
    f("radius", tool.radius);
    f("neck", tool.neck);
    f("reach", tool.reach);
    f("shank", tool.shank);
    f("length", tool.length);
  }
  bool operator==(const Lollipop&) const = default;
};

// T-slot cutter: a disc of that `height` on a thin neck; neck and shank as a lollipop's.
struct TSlot {
  static constexpr const char* kShape = "tslot";
  double radius = 6, height = 3, neck = 2.5, reach = 20, shank = 3, length = 40;
  static void for_numbers(auto& tool, auto&& f) {
    f("radius", tool.radius);
    f("height", tool.height);
    f("neck", tool.neck);
    f("reach", tool.reach);
    f("shank", tool.shank);
    f("length", tool.length);
  }
  bool operator==(const TSlot&) const = default;
};

// All tools: the one list of their shapes.
using Tool =
    std::variant<Finger, BallTool, Flat, Bull, Cone, Capsule, HalfSpace, BoxTool, Ellipsoid,
                 MeshTool, Drill, TaperedBall, Gouge, Vee, Chisel, Skew, Knife, Lollipop, TSlot>;

namespace internal {
template <class... Shape>
constexpr std::array<const char*, sizeof...(Shape)> shapes_of(
    std::type_identity<std::variant<Shape...>>) {
  return {Shape::kShape...};
}
}  // namespace internal

// The names of all shapes, in the order of Tool; scenes, documents and messages call them so.
inline constexpr auto kToolShapes = internal::shapes_of(std::type_identity<Tool>());

// The name of a tool's shape.
inline const char* shape_of(const Tool& tool) { return kToolShapes[tool.index()]; }

// A tool of the shape of that name, with its default numbers (a mesh tool without a mesh, which
// check_tool refuses); none where there is no such shape.
std::optional<Tool> default_tool(std::string_view shape);

// Calls f(name, number) for each number of a tool, in the order of its declaration. A number is a
// double& or, for sizes along x, y and z, a Vec3&; all are positive, lengths in mm and angles in
// degrees.
template <class F>
void for_tool_numbers(Tool& tool, F&& f) {
  std::visit([&](auto& t) { t.for_numbers(t, f); }, tool);
}
template <class F>
void for_tool_numbers(const Tool& tool, F&& f) {
  std::visit([&](const auto& t) { t.for_numbers(t, f); }, tool);
}

// Ok, or one sentence naming the parameter that can't be.
Status check_tool(const Tool& tool);

// The farthest point of the tool from its tip [mm]; infinite for a half-space.
double reach_mm(const Tool& tool);

// Whether no ray can leave the tool and enter it again.
bool is_convex(const Tool& tool);
// Its broad flat faces: across the first `axes` of the pose's directions, which begin with the
// tool's axis, and no wider than `size_mm` (infinite: that is not known).
struct FlatFaces {
  int axes = 0;
  double size_mm = 0;
};
FlatFaces flat_faces(const Tool& tool);

// The solid that `tool` sweeps while it moves by motion_mm without turning; in place, without
// allocation (but for a mesh). What of a long tool lies beyond the lattice is left out of the work:
// not what lies beyond the material, as that would reach the last digits of moments.
class SweptTool final : public Solid {
 public:
  SweptTool(const Tool& tool, const Pose& start, const Vec3& motion_mm, const Lattice& lattice,
            bool start_is_clear = false);

  ~SweptTool() override {
    for (size_t i = 0; i < count_; i++) solids_[i]->~Solid();
  }
  SweptTool(const SweptTool&) = delete;
  SweptTool& operator=(const SweptTool&) = delete;

  // The same solid, without the way through this one where there is a single piece.
  const Solid& solid() const { return *(count_ == 1 ? solids_[0] : this); }

  LatticeBox bounds() const override;
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  template <class T, class... Args>
  void add(Args&&... args) {
    solids_[count_] = new (&rooms_[count_]) T(std::forward<Args>(args)...);
    count_++;
  }

  // Bare memory, as variants would be cleared every tick.
  struct Room {
    alignas(64) std::byte bytes[std::max({sizeof(SweptBall), sizeof(SweptConvex), sizeof(SweptRim),
                                          sizeof(SweptMesh)})];
  };

  static constexpr size_t kMaxParts = 5;
  using Parts = std::array<SpanLayer, kMaxParts>;
  // What each part says of a tile; kept for each thread, as an edit asks for the normals of the
  // tile whose spans it has asked for.
  Parts& parts_of(const RayTile& rays, bool flip) const;

  // One solid, or convex solids. Where their union is convex, its interval is the hull of theirs;
  // else theirs are merged where they meet.
  std::array<Room, kMaxParts> rooms_;
  std::array<const Solid*, kMaxParts> solids_;  // in rooms_
  size_t count_ = 0;
  bool convex_;
  uint64_t id_;  // never given twice
};

}  // namespace kibori
