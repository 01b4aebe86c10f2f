// SPDX-License-Identifier: MIT
// A body that turns about a vertical axis, on a potter's wheel or a lathe (Sato et al.).
//
// Its state is its profile: for each row of nodes along z, the squared radii of the outside and of
// the hollow, in doubles. Between rows they are linear in z, so every volume is a sum:
//
//   V = pi sum_k w_k (a_k - b_k)
//
//   a = outside r^2, b = hollow r^2, w: length along z that a row represents
//
//        |<- sqrt(a) ->|
//        |             |      z
//     ___|___ _________|_     |        A tool casts a shadow on the profile: at each height,
//    |   |   |         | |             its minimum and maximum distance from the axis,
//    |   |___|         | |             as the body turns under it.
//    |_________________|_|
//
// The verbs, with the shadow from p to q:
//
//   throw  outside: a' = p^2 where the tool presses in. The missing volume returns on the
//          hollow's side where there is a wall, otherwise at the outside nearby.
//          hollow: b' = q^2, and a' = a + b' - b, so each ring keeps its volume.
//          V is kept to rounding.
//          With a second finger across the wall: b' = (sqrt(a') - wall)^2, or
//          a' = (sqrt(b') + wall)^2. The volume that it removes returns at the outside nearby.
//   turn   a' = min(a, p^2), b' = max(b, q^2): a lathe's cut.
//
// The rays are computed from the profile in closed form: |x| < sqrt(a - y^2), and along z where
// a(z) > x^2 + y^2 >= b(z). Therefore, the body is symmetric to float32.
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
  // The length along z that a row represents in volumes.
  double weight(size_t k) const;
  // Cubic lattice units.
  double volume() const;
  // Closes hollows that are too narrow to resolve, without a change of volume.
  void close_pinholes();
};

// The profile of the model's material about a vertical axis through `centre`. A body that is not
// symmetric is centred: each row keeps its area, and the whole body its volume.
WheelProfile read_profile(const TriDexel& model, const LatticePoint& centre);

// A body with this profile.
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
  // The interval of `layer` on a ray. Returns false if the ray has fewer intervals.
  bool interval(Axis axis, int u, int v, int layer, Interval& out) const;

  const WheelProfile& profile_;
  std::vector<double> outer_slope_, hollow_slope_;  // at the rows, of the squared radius
};

// One stroke on the wheel. For one thread at a time.
class Wheel {
 public:
  explicit Wheel(TriDexel& model) : model_(model) {}

  // Sets whether the model's lattice grows if the body becomes wider. Otherwise, the body is cut
  // off.
  void set_grows(bool grows) { grows_ = grows; }

  // Begins the stroke with the tool at `start`. The tool works on the hollow if it is in the
  // hollow, or above the body within the rim. Otherwise it works on the outside. `axis_mm`: a point
  // of the axis.
  void begin(const Vec3& axis_mm, const Tool& tool, const Pose& start);

  // Applies what the tool presses or cuts on its path from `from` by `displacement_mm` to the
  // model. `wall_mm` above 0, when clay is thrown: a second finger is at that distance from the
  // tool, across the hollow's wall. `pressed_mm3` is the volume that tool and finger pressed away
  // or cut [mm^3]. Errors: a place that is not finite.
  struct Turned {
    Reshaped what;
    double pressed_mm3 = 0;
  };
  Result<Turned> advance(WheelVerb verb, const Tool& tool, const Pose& from,
                         const Vec3& displacement_mm, double wall_mm = 0);

  const WheelProfile& profile() const { return profile_; }

 private:
  struct Shadow {
    double nearest, farthest;  // squared; nearest > farthest: none
  };
  void cast_shadow(const Tool& tool, const Pose& from, const Vec3& displacement_mm);

  TriDexel& model_;
  WheelProfile profile_;
  bool in_hollow_ = false, grows_ = false;
  std::vector<Shadow> shadow_;
};

}  // namespace kibori
