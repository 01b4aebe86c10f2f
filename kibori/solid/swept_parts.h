// SPDX-License-Identifier: MIT
// The parts of a swept tool. A tool shape adds them in `add_parts`. All parts make the same
// straight motion. Parts may overlap: their union is the tool.
//
//     |    |
//     |    |    cylinder(shank, reach, length)
//     +-  -+    <- reach
//      |  |     cylinder(neck, radius, length)
//     .+--+.
//    (      )   ball(radius)
//     `----'    <- tip, height 0
//
// Arguments named _mm are in mm, those named _deg in degrees. Heights start at the tip. Everything
// else is in lattice units: mm times scale(). If a tool is longer than the lattice, the part beyond
// the lattice is omitted. Do not omit more, such as the part above the material: that would change
// the last digits of moments.
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

// Sine and cosine of half a full angle in degrees.
inline SinCos half_angle(double angle_deg) { return sin_cos(angle_deg * (std::numbers::pi / 360)); }

// The top of a body [lattice units]. If the top is above the lattice, no ray can meet it, so the
// body gets no top face. `length` is the real height of the top. `height` is limited to the
// lattice.
struct BodyTop {
  double height, length;
  bool has_face;

  BodyTop(double whole, double useful)
      : height(std::min(whole, useful)), length(whole), has_face(whole <= useful) {}
  void close(ConvexBody& body) const {
    if (has_face) body.add_plane(Vec3(0, 0, -1), height);
  }
};

// A cylinder around the axis from z0 up [lattice units].
ConvexBody cylinder_body(double radius, double z0, const BodyTop& top);

// The parts are stored in place. Only a mesh allocates.
class SweptParts {
 public:
  static constexpr size_t kMaxParts = 5;

  // start_is_clear: the start pose holds no material, so `spans` may omit rays on which the sweep
  // reaches nothing beyond it.
  SweptParts(const Pose& start, const Vec3& motion_mm, const Lattice& lattice, bool start_is_clear);
  ~SweptParts() {
    for (size_t i = 0; i < count_; i++) solids_[i]->~Solid();
  }
  SweptParts(const SweptParts&) = delete;
  SweptParts& operator=(const SweptParts&) = delete;

  size_t count() const { return count_; }
  const Solid& operator[](size_t i) const { return *solids_[i]; }

  // A ball whose lowest point is the tip.
  void ball(double radius_mm);
  // Parts between two heights. Adds nothing if they are empty or above the lattice.
  void cylinder(double radius_mm, double from_mm, double to_mm);
  void upright_box(double x_mm, double y_mm, double from_mm, double to_mm);
  // A cone of this full angle, cut between two heights. Adds nothing if it is above the lattice.
  void cone(double angle_deg, double apex_mm, double from_mm, double to_mm);
  // A blade of x by y mm. Its edge is a V of this full angle, along x (`along` is 0) or y (1). Its
  // sides are upright above the V.
  void wedge_blade(int along, double angle_deg, double x_mm, double y_mm, double length_mm);
  // A closed mesh in tool coordinates.
  void mesh(std::shared_ptr<const TriangleMesh> mesh);
  // A body in the tool frame.
  void convex(const ConvexBody& body);
  // A solid of type T from its constructor's arguments.
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
  // A height above the lattice's farthest corner, during the whole motion [lattice units]. A body
  // meets nothing above it.
  double useful() const;
  BodyTop top(double height_mm) const { return {height_mm * scale(), useful()}; }

 private:
  // Raw memory, because a std::variant would be cleared in every tick.
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
  std::array<const Solid*, kMaxParts> solids_;  // in rooms_
  size_t count_ = 0;
};

}  // namespace kibori
