// SPDX-License-Identifier: MIT
// A body that turns about a vertical axis: on a potter's wheel or a lathe (Sato et al.).
//
// Its state is its profile: for each row of nodes along z the squared radii of the outside and of
// the hollow, in doubles; between rows they are linear in z, so that every volume is a sum:
//
//   V = pi sum_k w_k (a_k - b_k)          a = outside r^2, b = hollow r^2, w: length of the row's
//   part
//
//        |<- sqrt(a) ->|
//        |             |      z
//     ___|___ _________|_     |        A tool casts a shadow on the profile: at each height the
//    |   |   |         | |             nearest and the farthest that it comes to the axis, as
//    |   |___|         | |             the body turns under it.
//    |_________________|_|
//
//   throw  outside: a' = p^2 where it is pressed in; what is missing comes back to the hollow's
//   side
//          where the wall is, and else to the outside nearby. hollow: b' = q^2, and a' = a + b' -
//          b, so each ring keeps its volume. V is kept to rounding.
//          A second finger across the wall: b' = (sqrt(a') - wall)^2, or a' = (sqrt(b') + wall)^2,
//          and what it takes comes to the outside nearby.
//   turn   a' = min(a, p^2), b' = max(b, q^2): a lathe's cut.
//
// The rays are told anew from the profile in closed form: |x| < sqrt(a - y^2), and along z where
// a(z) > x^2 + y^2 >= b(z): so the body is symmetric to float32.
#pragma once

#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/reshape/brush.h>
#include <kibori/solid/tool.h>

namespace kibori {

enum class WheelVerb { throw_clay, turn };

// A profile [lattice units]: rows at z = first + k + 1/2.
struct WheelProfile {
  Vec3 centre = Vec3::Zero();  // a point of the axis; its z is not used
  int first = 0;
  double low = 0, high = 0;           // the flat bottom and top
  std::vector<double> outer, hollow;  // squared radii
  uint8_t material = 0;

  bool empty() const { return outer.empty(); }
  double row_z(size_t k) const { return first + static_cast<double>(k) + 0.5; }
  // The length of z for which a row stands in volumes.
  double weight(size_t k) const;
  // Cubic lattice units.
  double volume() const;
  // Hollows that are too narrow to be told, without a change of volume.
  void close_pinholes();
};

// The profile of what is in the model, about a vertical axis through `centre`. A body that is not
// symmetric is centred: each row keeps its area, the whole its volume.
WheelProfile read_profile(const TriDexel& model, const LatticePoint& centre);

// A body of that profile.
class WheelSolid final : public Solid {
 public:
  explicit WheelSolid(const WheelProfile& profile);
  LatticeBox bounds() const override;
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  struct End {
    double depth = 0;
    uint32_t normal = 0;  // out of the body
  };
  struct Interval {
    End lo, hi;
  };
  // The interval of that layer on a ray; false where it has not so many.
  bool interval(Axis axis, int u, int v, int layer, Interval& out) const;

  const WheelProfile& profile_;
  std::vector<double> outer_slope_, hollow_slope_;  // at the rows, of the squared radius
};

// One stroke on the wheel. For one thread at a time.
class Wheel {
 public:
  explicit Wheel(TriDexel& model) : model_(model) {}

  // The stroke begins with the tool at `start`: it works the hollow where it stands in it, or above
  // the body within the rim; else the outside. `axis_mm`: a point of the axis.
  void begin(const Vec3& axis_mm, const Tool& tool, const Pose& start);

  // What the tool presses or cuts as it is swept from `from` by `way_mm`, into the model.
  // `wall_mm`, where clay is thrown: above 0 a second finger stands that far from the tool across a
  // hollow's wall. `pressed`: the volume that they met [mm^3]. Errors: a place that is not finite.
  struct Turned {
    Reshaped what;
    double pressed_mm3 = 0;
  };
  Result<Turned> advance(WheelVerb verb, const Tool& tool, const Pose& from, const Vec3& way_mm,
                         double wall_mm = 0);

  const WheelProfile& profile() const { return profile_; }

 private:
  struct Shadow {
    double nearest, farthest;  // squared; nearest > farthest: none
  };
  void cast_shadow(const Tool& tool, const Pose& from, const Vec3& way_mm);

  TriDexel& model_;
  WheelProfile profile_;
  bool in_hollow_ = false;
  std::vector<Shadow> shadow_;
};

}  // namespace kibori
