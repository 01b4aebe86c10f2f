// SPDX-License-Identifier: MIT
// Volume from nodes and ends.
//
//   V = h^3 (N + sum over the ends of all fields of n_i^2 d)
//
// N is the number of lattice nodes inside. d is a signed distance in cells, positive out of the
// material. It is measured from the boundary of the outermost node's cell to the end. n_i is the
// component of the end's unit normal along its ray. The sum is a surface integral. The weights
// n_i^2 add up to 1 over the three fields. So each surface element counts once, mostly by the rays
// that are normal to it. The position of a shape on the lattice changes the result only in second
// order. The volume is a function of the state: the volumes that edits remove add up to the missing
// volume.
//
// Node k of a ray is at k + 1/2. A span [in, out) contains it if in <= k + 1/2 < out. N comes from
// the z field. A face along x or y can coincide with a plane of nodes. There, float32 may put the
// ends of its own field on one side of the nodes, and the z field on the other side. A whole layer
// of cells would be lost, so the z field decides (is_tied).
#pragma once

#include <cmath>
#include <cstdint>

#include <kibori/dexel/normal_code.h>

namespace kibori {

// The first node at or after `depth`. The boundary of its cell rounds to this depth, too.
inline float first_node(float depth) { return std::ceil(depth - 0.5f); }

// An end within kTie [cells] of a node is tied to it, if its face is perpendicular to the ray: the
// weight is above kTiedWeight. Float32 moves ends of one plane by less. Few other ends are tied, so
// their side of the node does not matter. An edge may lie on two planes of nodes. So a node
// within kTie of the z field's own end counts as outside. Then the moment at which a row of nodes
// vanishes does not matter.
inline constexpr float kTie = 1e-4f, kTiedWeight = 0.98f;
inline bool is_tied(float depth, float weight) {
  const float t = depth - 0.5f;
  return weight > kTiedWeight && std::fabs(t - std::nearbyint(t)) < kTie;
}
inline int tied_node(float depth) { return static_cast<int>(std::nearbyint(depth - 0.5f)); }

// Contribution of a piece [lo, hi) of one ray. `weight_lo` and `weight_hi` are the weights of its
// ends (depth_weight).
struct RayVolume {
  float first, last;                   // it contains the nodes first <= k < last
  float correction_lo, correction_hi;  // [cells]; they act half way between cell boundary and end

  RayVolume(float lo, float hi, float weight_lo, float weight_hi)
      : RayVolume(
            lo, hi, weight_lo, weight_hi, [](int, bool) { return false; }, false) {}
  // `holds(k, at_hi)`: true if the piece contains the node that its end is tied to. Called only for
  // rays along x and y.
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
