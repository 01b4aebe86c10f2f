// SPDX-License-Identifier: MIT
// The rays of one dexel field near a point, and their spans in a snapshot. A page draws them to
// show the method itself: rays, dexels and vanishing points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

inline constexpr int kMaxBoxRays = 32;             // along u and along v
inline constexpr size_t kMaxBoxSpans = 16;         // per ray
inline constexpr size_t kMaxVanishedNodes = 2048;  // in the list

// The rays u, u + every, ... (`columns` of them) by v, v + every, ... (`rows` of them) of a field,
// between two depths [lattice units].
struct RayBox {
  Axis axis = Axis::z;
  int every = 1;
  int u = 0, v = 0, columns = 0, rows = 0;
  double low = 0, high = 0;
  // The first and last ray of the cube in both directions, whether multiples of `every` or not.
  int first_u = 0, last_u = -1, first_v = 0, last_v = -1;
};

// The rays whose indices are multiples of `every`, in the cube with this half side about
// `centre_mm`. So the shown rays do not move with the cube. `every` is doubled until at most
// kMaxBoxRays remain per direction. There are no rays if the cube is outside the lattice.
RayBox ray_box(const Lattice& lattice, Axis axis, const Vec3& centre_mm, double radius_mm,
               int every);

// The spans of each ray between the depths of the box, at most kMaxBoxSpans. u changes fastest.
std::vector<std::vector<Span>> spans_in(const RayBox& box, const Snapshot& snapshot);

struct VanishedNodes {
  size_t count = 0;
  // All vanished nodes, or kMaxVanishedNodes of them, evenly chosen: x, y and z index.
  std::vector<std::array<int16_t, 3>> nodes;
};
// The same cube with four times as many rays in both directions, or all of them.
RayBox finer(const RayBox& box);

// Finds lattice nodes on the rays of the box and between its depths. They were in the material of
// `before` and are not in that of `now`.
VanishedNodes vanished_in(const RayBox& box, const Snapshot& before, const Snapshot& now);

}  // namespace kibori
