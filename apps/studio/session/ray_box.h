// SPDX-License-Identifier: MIT
// The rays of one dexel field near a point, and their spans in a snapshot. A page draws them to
// show how the model works: rays, dexels and vanished points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

inline constexpr int kMaxBoxRays = 32;             // along u, and along v
inline constexpr size_t kMaxBoxSpans = 16;         // per ray
inline constexpr size_t kMaxVanishedNodes = 2048;  // in VanishedNodes::nodes

// A box of rays of one field, between two depths [lattice units]. `columns` rays have the u indices
// u, u + every, u + 2 every, and so on. In the same way, `rows` rays have the v indices v, v +
// every, and so on.
struct RayBox {
  Axis axis = Axis::z;
  int every = 1;
  int u = 0, v = 0, columns = 0, rows = 0;
  double low = 0, high = 0;
  // The first and the last ray of the cube in both directions. They need not be multiples of
  // `every`.
  int first_u = 0, last_u = -1, first_v = 0, last_v = -1;
};

// Returns the rays in the cube around `centre_mm` with half side `radius_mm`, whose indices are
// multiples of `every`. So the rays do not move with the cube. `every` is doubled until each
// direction has at most kMaxBoxRays rays. If the cube is outside the lattice, there are no rays.
RayBox ray_box(const Lattice& lattice, Axis axis, const Vec3& centre_mm, double radius_mm,
               int every);

// Returns the spans of each ray between the depths of the box, at most kMaxBoxSpans per ray. u
// changes fastest.
std::vector<std::vector<Span>> spans_in(const RayBox& box, const Snapshot& snapshot);

struct VanishedNodes {
  size_t count = 0;
  // The x, y and z indices of the listed nodes: every n-th vanished node, at most
  // kMaxVanishedNodes.
  std::vector<std::array<int16_t, 3>> nodes;
};
// Returns the same cube with four times as many rays in both directions, or with all its rays.
RayBox finer(const RayBox& box);

// Finds the vanished nodes on the rays of the box and between its depths. They are within the
// material of `before`, but not within the material of `now`.
VanishedNodes vanished_in(const RayBox& box, const Snapshot& before, const Snapshot& now);

}  // namespace kibori
