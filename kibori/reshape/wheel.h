// SPDX-License-Identifier: MIT
// A body that turns about a vertical axis, on a potter's wheel or a lathe (Sato et al.). The body
// may have a hollow.
//
// The state of the body is its profile. For each row of nodes along z, the profile has the squared
// radius of the outside and of the hollow, in doubles. Between rows, the squared radii are linear
// in z. Therefore, every volume is a sum:
//
//   V = pi sum_k w_k (a_k - b_k)
//
//   a = squared outside radius, b = squared hollow radius, w: length along z that a row represents
//
//        |<- sqrt(a) ->|
//        |             |      z
//     ___|___ _________|_     |        A tool casts a shadow on the profile: at each height,
//    |   |   |         | |             its minimum and maximum distance from the axis,
//    |   |___|         | |             as the body turns under it.
//    |_________________|_|
//
// The verbs. At a row of the profile, p is the shadow's minimum distance from the axis, and q its
// maximum distance. a' and b' are the new values.
//
//   throw  The tool presses from outside: a' = p^2. If the row has a hollow, the hollow becomes
//          narrower by the missing volume. The rest of this volume returns at the outside nearby.
//          The tool presses in the hollow: b' = q^2, and a' = a + b' - b, so each ring keeps its
//          volume. V is constant except for rounding errors.
//          With a second finger, a thicker wall becomes `wall` thick: b' = (sqrt(a') - wall)^2, or
//          a' = (sqrt(b') + wall)^2. The volume that it removes returns at the outside nearby.
//   turn   A lathe cut: a' = min(a, p^2) at the outside, b' = max(b, q^2) in the hollow.
//
// The spans are computed from the profile in closed form: |x| < sqrt(a - y^2) for x rays, and a(z)
// > x^2 + y^2 >= b(z) along z. Therefore, the body is symmetric within the precision of float32.
#pragma once

#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/reshape/brush.h>
#include <kibori/solid/tool.h>

namespace kibori {

enum class WheelVerb { throw_clay, turn };

// A profile [lattice units]. Row k is at z = first + k + 1/2.
struct WheelProfile {
  Vec3 centre = Vec3::Zero();  // a point on the axis; its z is not used
  int first = 0;
  double low = 0, high = 0;           // z of the flat bottom and of the flat top
  std::vector<double> outer, hollow;  // squared radii, for each row
  uint8_t material = 0;

  bool empty() const { return outer.empty(); }
  double row_z(size_t k) const { return first + static_cast<double>(k) + 0.5; }
  // Returns the length along z that row k represents in volumes.
  double weight(size_t k) const;
  // Returns the volume [lattice units^3].
  double volume() const;
  // Closes hollows that are too narrow to resolve. The volume does not change.
  void close_pinholes();
};

// Returns the profile of the model's material about a vertical axis through `centre`. If the body
// is not symmetric, the profile is centred: each row keeps its area, and the body keeps its volume.
WheelProfile read_profile(const TriDexel& model, const LatticePoint& centre);

// The body of a profile. The profile must live longer than this object.
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
  // Computes interval number `layer` of a ray. Returns false if the ray has fewer intervals.
  bool interval(Axis axis, int u, int v, int layer, Interval& out) const;

  const WheelProfile& profile_;
  std::vector<double> outer_slope_, hollow_slope_;  // of the squared radii along z, per row
};

// One stroke on the wheel. One thread may use it at a time.
class Wheel {
 public:
  explicit Wheel(TriDexel& model) : model_(model) {}

  // If `grows` is true, the model's lattice grows when the body becomes wider. Otherwise, the body
  // is cut off.
  void set_grows(bool grows) { grows_ = grows; }

  // Begins a stroke with the tool at `start`. If the tool is in the hollow, or above the body and
  // within its rim, it works on the hollow. Otherwise, it works on the outside. `axis_mm` is a
  // point on the axis.
  void begin(const Vec3& axis_mm, const Tool& tool, const Pose& start);

  // Moves the tool from `from` by `displacement_mm`. Applies to the model what the tool presses
  // (throw) or cuts (turn) on this path. `wall_mm`, only for throw: if above 0, a second finger is
  // at this distance from the tool, across the wall. `pressed_mm3` is the volume that the tool and
  // the finger pressed away or cut. Errors: a position is not finite.
  struct Turned {
    Reshaped what;
    double pressed_mm3 = 0;
  };
  Result<Turned> advance(WheelVerb verb, const Tool& tool, const Pose& from,
                         const Vec3& displacement_mm, double wall_mm = 0);

  const WheelProfile& profile() const { return profile_; }

 private:
  struct Shadow {
    double nearest, farthest;  // squared distances; nearest > farthest: no shadow
  };
  void cast_shadow(const Tool& tool, const Pose& from, const Vec3& displacement_mm);

  TriDexel& model_;
  WheelProfile profile_;
  bool in_hollow_ = false, grows_ = false;
  std::vector<Shadow> shadow_;
};

}  // namespace kibori
