// SPDX-License-Identifier: MIT
// Volume from nodes and ends.
//
//   V = h^3 (N + sum over the ends of all fields of n_i^2 d)
//
// N is the number of lattice nodes inside. Each end has a nearest node inside its span. d is the
// distance in cells from the boundary of this node's cell to the end. It is positive if the end is
// outside of the cell. n_i is the component of the end's unit normal along its ray. The sum is a
// surface integral. The weights n_i^2 add up to 1 over the three fields. So each surface element
// counts once, mostly by the rays that are normal to it. The position of a shape on the lattice
// changes the result only in second order. The volume is a function of the model's state. So the
// volumes that edits remove add up to the difference of the volumes before and after.
//
// Node k of a ray is at k + 1/2. A span [in, out) contains it if in <= k + 1/2 < out. N comes from
// the z field. A face perpendicular to x can coincide with a plane of nodes. Then float32 rounding
// may put the ends of the x field on one side of the nodes, and the z field on the other side. The
// sum would be wrong by a whole layer of cells. So the z field decides (is_tied). The same is true
// for y.
#pragma once

#include <cmath>
#include <cstdint>

#include <kibori/dexel/normal_code.h>

namespace kibori {

// The first node at or after `depth`. The result is also the depth of the lower boundary of the
// node's cell.
inline float first_node(float depth) { return std::ceil(depth - 0.5f); }

// An end is tied to a node if it is within kTie [cells] of the node and its weight is above
// kTiedWeight: its face is perpendicular to the ray. For a tied end, the z field decides whether
// the node is inside. kTie is larger than the float32 error of a plane's position. Few other ends
// are so close to a node by chance, so this rule hardly changes their volume. Along an edge of two
// faces, the z field's own end can also be within kTie of the node. Then the node counts as
// outside. So the volume does not depend on which edit removes the nodes along the edge.
inline constexpr float kTie = 1e-4f, kTiedWeight = 0.98f;
// An end on a node is half a cell from the boundaries of the node's cell.
inline bool is_tied(float depth, float weight) {
  return std::fabs(first_node(depth) - depth) > 0.5f - kTie && weight > kTiedWeight;
}
inline int tied_node(float depth) { return static_cast<int>(std::nearbyint(depth - 0.5f)); }

// Contribution of a piece [lo, hi) of one ray. `weight_lo` and `weight_hi` are the weights of its
// ends (depth_weight).
struct RayVolume {
  float first, last;                   // it contains the nodes first <= k < last
  float correction_lo, correction_hi;  // [cells]; each centred between cell boundary and end

  RayVolume(float lo, float hi, float weight_lo, float weight_hi)
      : RayVolume(
            lo, hi, weight_lo, weight_hi, [](int, bool) { return false; }, false) {}
  // `holds(k, at_hi)`: true if the piece contains the node that its end is tied to. `ask` is false
  // for rays along z, and holds is not called then: the z field itself decides.
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
