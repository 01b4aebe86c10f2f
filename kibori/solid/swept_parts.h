// SPDX-License-Identifier: MIT
// The parts of a tool that moves along a straight line. A tool shape adds its parts in `add_parts`.
// All parts make the same motion. The tool is the union of its parts, which may overlap.
//
//     |    |
//     |    |    cylinder(shank, reach, length)
//     +-  -+    <- reach
//      |  |     cylinder(neck, radius, length)
//     .+--+.
//    (      )   ball(radius)
//     `----'    <- tip, height 0
//
// Arguments named _mm are in mm, those named _deg in degrees. Everything else is in lattice units:
// mm times scale(). Heights start at the tip. If a tool is longer than the lattice, the part of the
// tool beyond the lattice is omitted. Do not omit more, such as the part above the material: that
// would change the last digits of moments.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <new>
#include <numbers>
#include <utility>

#include <kibori/base/trig.h>
#include <kibori/geometry/mesh.h>
#include <kibori/solid/ball.h>
#include <kibori/solid/convex.h>
#include <kibori/solid/mesh_solid.h>
#include <kibori/solid/rim.h>

namespace kibori {

// Returns the sine and cosine of half an angle. The angle is in degrees.
inline SinCos half_angle(double angle_deg) { return sin_cos(angle_deg * (std::numbers::pi / 360)); }

// The top of a body [lattice units]. `length` is the real height of the top, and `height` is this
// height limited to the lattice. If the real top is above the lattice, no ray can meet it, so the
// body gets no top face.
struct BodyTop {
  double height, length;
  bool has_face;

  BodyTop(double whole, double useful)
      : height(std::min(whole, useful)), length(whole), has_face(whole <= useful) {}
  void close(ConvexBody& body) const {
    if (has_face) body.add_plane(Vec3(0, 0, -1), height);
  }
};

// Makes a cylinder around the axis, from height z0 up to `top` [lattice units].
ConvexBody cylinder_body(double radius, double z0, const BodyTop& top);

// The parts are stored inside the object. Only a mesh allocates memory.
class SweptParts {
 public:
  static constexpr size_t kMaxParts = 5;

  // With `start_is_clear`, the caller promises that there is no material inside the tool at the
  // start pose. `spans` may then omit rays on which the sweep reaches nothing outside of the tool
  // at that pose.
  SweptParts(const Pose& start, const Vec3& motion_mm, const Lattice& lattice, bool start_is_clear);
  ~SweptParts() {
    for (size_t i = 0; i < count_; i++) solids_[i]->~Solid();
  }
  SweptParts(const SweptParts&) = delete;
  SweptParts& operator=(const SweptParts&) = delete;

  size_t count() const { return count_; }
  const Solid& operator[](size_t i) const { return *solids_[i]; }

  // Adds a ball whose lowest point is the tip.
  void ball(double radius_mm);
  // The next two functions add a part from height from_mm to height to_mm. If the part is empty, or
  // above the lattice, they add nothing.
  void cylinder(double radius_mm, double from_mm, double to_mm);
  void upright_box(double x_mm, double y_mm, double from_mm, double to_mm);
  // Adds a cone with this full angle at its apex, from height from_mm to height to_mm. If the part
  // is above the lattice, adds nothing.
  void cone(double angle_deg, double apex_mm, double from_mm, double to_mm);
  // Adds a blade of x by y mm. Its edge is a V with this full angle, along x (`along` is 0) or y
  // (1). Above the V, its sides are parallel to the axis.
  void wedge_blade(int along, double angle_deg, double x_mm, double y_mm, double length_mm);
  // Adds a closed mesh in tool coordinates [mm].
  void mesh(std::shared_ptr<const TriangleMesh> mesh);
  // Adds a body in the tool frame [lattice units].
  void convex(const ConvexBody& body);
  // Adds a solid of type T, made from its constructor's arguments.
  template <class T, class... Args>
  void add(Args&&... args) {
    solids_[count_] = new (&rooms_[count_]) T(std::forward<Args>(args)...);
    count_++;
  }

  double scale() const { return 1 / lattice_.pitch_mm; }
  double pitch_mm() const { return lattice_.pitch_mm; }
  LatticePoint above_tip(double height) const {
    return tip_ + LatticeVector{height * start_.axis()};
  }
  Vec3 axis() const { return start_.axis(); }
  const Mat3& frame() const { return start_.frame; }
  const LatticeVector& motion() const { return motion_; }
  bool start_is_clear() const { return start_is_clear_; }
  // Returns a height that is above the lattice's farthest corner during the whole motion [lattice
  // units]. No ray meets a part of the tool above this height.
  double useful() const;
  BodyTop top(double height_mm) const { return {height_mm * scale(), useful()}; }

 private:
  // Raw memory for one part. With a std::variant, every tick would clear this memory.
  struct Room {
    alignas(64) std::byte bytes[std::max({sizeof(SweptBall), sizeof(SweptConvex), sizeof(SweptRim),
                                          sizeof(SweptMesh)})];
  };

  Pose start_;
  Vec3 motion_mm_;
  Lattice lattice_;
  bool start_is_clear_;
  LatticePoint tip_;
  LatticeVector motion_;
  std::array<Room, kMaxParts> rooms_;
  std::array<const Solid*, kMaxParts> solids_;  // point into rooms_
  size_t count_ = 0;
};

}  // namespace kibori
