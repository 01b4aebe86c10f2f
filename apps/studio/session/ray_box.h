// SPDX-License-Identifier: MIT
// The rays of one dexel field near a place, and what a snapshot says of them: what a page draws to
// show the method itself (rays, dexels, points that vanish).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

inline constexpr int kMaxBoxRays = 32;             // along u and along v
inline constexpr size_t kMaxBoxSpans = 16;         // of one ray
inline constexpr size_t kMaxVanishedNodes = 2048;  // that are listed

// Rays u, u + every, ... (columns of them) by v, v + every, ... (rows of them) of a field, between
// two depths [lattice units].
struct RayBox {
  Axis axis = Axis::z;
  int every = 1;
  int u = 0, v = 0, columns = 0, rows = 0;
  double low = 0, high = 0;
  // The first and last ray of the cube both ways, whether or not they are multiples of `every`.
  int first_u = 0, last_u = -1, first_v = 0, last_v = -1;
};

// The rays of the cube of that half side about `centre_mm` whose indices are multiples of `every`,
// so that the same rays are shown wherever the cube moves. `every` is doubled until kMaxBoxRays are
// enough. No rays where the cube does not meet the lattice.
RayBox ray_box(const Lattice& lattice, Axis axis, const Vec3& centre_mm, double radius_mm,
               int every);

// Of each ray of the box, u first: the spans that reach between its depths, kMaxBoxSpans at most.
std::vector<std::vector<Span>> spans_in(const RayBox& box, const Snapshot& snapshot);

struct VanishedNodes {
  size_t count = 0;
  // All of them, or kMaxVanishedNodes at most, evenly chosen: x, y and z index.
  std::vector<std::array<uint16_t, 3>> nodes;
};
// Of the same cube, four times as many rays both ways, or all of them.
RayBox finer(const RayBox& box);

// The lattice nodes on the box's rays and between its depths that lie in the material before, and
// not in the material now, as this field tells.
VanishedNodes vanished_in(const RayBox& box, const Snapshot& before, const Snapshot& now);

}  // namespace kibori
