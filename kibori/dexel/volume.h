// SPDX-License-Identifier: MIT
// The volume of a model, computed from its nodes and the ends of its spans.
//
//   V = h^3 (N + sum over the ends of all fields of n_i^2 d)
//
// N is the number of lattice nodes inside. The cell of a node is the cube around the node whose
// side is the pitch h. Each end belongs to a cell boundary on its ray. For an `in` end, it is the
// lower boundary of the cell of the first node at or after the end. For an `out` end, it is the
// upper boundary of the cell of the last node before the end. d is the distance [cells] from the
// boundary to the end. It is positive if the span extends beyond the boundary. n_i is the component
// of the end's unit normal along the ray.
//
// The sum is an integral over the surface. Over the three fields, the weights n_i^2 add up to 1.
// Therefore, each surface element counts once, mostly by the rays that are normal to it. The
// position of a shape relative to the lattice changes the result only in second order. The volume
// depends only on the model's state. Therefore, the volumes that edits remove add up to the
// difference of the volumes before and after.
//
// Node k of a ray is at k + 1/2. A span [in, out) contains the node if in <= k + 1/2 < out. N comes
// from the z field. A face perpendicular to x can coincide with a plane of nodes. Because of
// float32 rounding, the z field may then count these nodes as inside, and the x field as outside,
// or vice versa. The sum would be wrong by a whole layer of cells. Therefore, the z field decides
// for such ends of the x field (is_tied). The same is true for y.
#pragma once

#include <cmath>
#include <cstdint>

#include <kibori/dexel/normal_code.h>

namespace kibori {

// Returns the first node at or after `depth`. As a depth, the same number is the lower boundary of
// the node's cell.
inline float first_node(float depth) { return std::ceil(depth - 0.5f); }

// An end is tied to a node if it is within kTie [cells] of the node, and its weight is above
// kTiedWeight. (A large weight means that the face is perpendicular to the ray.) For a tied end,
// the z field decides whether the node is inside. kTie is larger than the float32 error of a
// plane's position. Few other ends are so close to a node by chance, so the rule hardly changes the
// volume. Along the edge between two faces, an end of the z field can also be within kTie of the
// node. Then the node counts as outside. Therefore, the volume does not depend on which edit
// removes the nodes along the edge.
inline constexpr float kTie = 1e-4f, kTiedWeight = 0.98f;
// first_node returns a boundary of a cell. An end on a node is half a cell from this boundary.
inline bool is_tied(float depth, float weight) {
  return std::fabs(first_node(depth) - depth) > 0.5f - kTie && weight > kTiedWeight;
}
inline int tied_node(float depth) { return static_cast<int>(std::nearbyint(depth - 0.5f)); }

// Contribution of a piece [lo, hi) of one ray to the volume. `weight_lo` and `weight_hi` are the
// weights of its ends (depth_weight).
struct RayVolume {
  float first, last;                   // the piece contains the nodes first <= k < last
  float correction_lo, correction_hi;  // [cells]; centred between the boundary and the end

  // Does not check for tied ends.
  RayVolume(float lo, float hi, float weight_lo, float weight_hi)
      : RayVolume(
            lo, hi, weight_lo, weight_hi, [](int, bool) { return false; }, false) {}
  // `holds(k, at_hi)` returns true if the piece contains node k, to which its end is tied (lo, or
  // hi if `at_hi`). If `ask` is false, `holds` is not called. This is right for rays along z,
  // because the z field itself decides.
  template <class Holds>
  RayVolume(float lo, float hi, float weight_lo, float weight_hi, Holds&& holds, bool ask = true)
      : first(first_node(lo)), last(first_node(hi)) {
    if (ask && is_tied(lo, weight_lo)) {
      const int node = tied_node(lo);
      first = static_cast<float>(holds(node, false) ? node : node + 1);
    }
    if (ask && is_tied(hi, weight_hi)) {
      const int node = tied_node(hi);
      last = static_cast<float>(holds(node, true) ? node + 1 : node);
    }
    correction_lo = weight_lo * (first - lo);
    correction_hi = weight_hi * (hi - last);
  }
  double nodes() const { return double{last} - double{first}; }
  double correction() const { return double{correction_lo} + double{correction_hi}; }
};

}  // namespace kibori
