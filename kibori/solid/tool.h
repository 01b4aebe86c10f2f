// SPDX-License-Identifier: MIT
// Tools: shapes a user can hold, in their own frame (tip at the origin, body along +z, mm), and the solid a
// tool sweeps in a straight motion. Adding a shape: a struct here, its checks and its body in tool.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <variant>

#include <kibori/base/result.h>
#include <kibori/dexel/field.h>
#include <kibori/geometry/mesh.h>
#include <kibori/solid/ball.h>
#include <kibori/solid/convex.h>
#include <kibori/solid/mesh_solid.h>
#include <kibori/solid/rim.h>

namespace kibori {

// The paper's virtual finger (eq. 1): inside where z - ks (x^2 + y^2) > 0, up to z = length. ks [1/mm].
struct Finger {
  double ks = 0.1, length = 40;
  bool operator==(const Finger&) const = default;
};
struct BallTool {
  double radius = 5;
  bool operator==(const BallTool&) const = default;
};
// Flat end mill: a cylinder that stands on its tip.
struct Flat {
  double radius = 3, length = 30;
  bool operator==(const Flat&) const = default;
};
// Bull-nose end mill: a flat whose rim is rounded by `corner` <= radius.
struct Bull {
  double radius = 5, corner = 1, length = 30;
  bool operator==(const Bull&) const = default;
};
// V cutter: a cone of full angle angle_deg up to `radius`, a cylinder from there to `length`.
struct Cone {
  double angle_deg = 60, radius = 5, length = 30;
  bool operator==(const Cone&) const = default;
};
// A cylinder with round ends; `length` from tip to end.
struct Capsule {
  double radius = 3, length = 20;
  bool operator==(const Capsule&) const = default;
};
// Everything on the body's side of the plane through the tip.
struct HalfSpace {
  bool operator==(const HalfSpace&) const = default;
};
// A box whose lower face is centred on the tip.
struct BoxTool {
  Vec3 size = Vec3(10, 10, 10);
  bool operator==(const BoxTool& other) const { return size == other.size; }
};
// The tip is its lowest point.
struct Ellipsoid {
  Vec3 radii = Vec3(5, 5, 5);
  bool operator==(const Ellipsoid& other) const { return radii == other.radii; }
};
// A closed mesh in tool coordinates.
struct MeshTool {
  std::shared_ptr<const TriangleMesh> mesh;
  bool operator==(const MeshTool&) const = default;
};

using Tool =
    std::variant<Finger, BallTool, Flat, Bull, Cone, Capsule, HalfSpace, BoxTool, Ellipsoid, MeshTool>;

// Ok, or one sentence naming the parameter that can't be.
Status check_tool(const Tool& tool);

// Whether two tools are the same in all they have.
inline bool same_tool(const Tool& a, const Tool& b) { return a == b; }

// The farthest point of the tool from its tip [mm]; infinite for a half-space.
double reach_mm(const Tool& tool);

// The solid that `tool` sweeps while it moves by motion_mm without turning; in place, without allocation (but
// for a mesh). Parts of long tools that lie beyond `material` [lattice units] are left out of the work.
class SweptTool final : public Solid {
 public:
  SweptTool(const Tool& tool, const Pose& start, const Vec3& motion_mm, const Lattice& lattice,
            const Box& material, bool start_is_clear = false);

  ~SweptTool() override {
    for (size_t i = 0; i < count_; i++) solids_[i]->~Solid();
  }
  SweptTool(const SweptTool&) = delete;
  SweptTool& operator=(const SweptTool&) = delete;

  // The same solid, without the way through this one where there is a single piece.
  const Solid& solid() const { return *(count_ == 1 ? solids_[0] : this); }

  Box bounds() const override;
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
    alignas(64) std::byte
        bytes[std::max({sizeof(SweptBall), sizeof(SweptConvex), sizeof(SweptRim), sizeof(SweptMesh)})];
  };

  // One solid, or convex solids whose union is convex: the interval of the union is the hull of theirs.
  std::array<Room, 5> rooms_;
  std::array<const Solid*, 5> solids_;  // in rooms_
  size_t count_ = 0;
};

}  // namespace kibori
