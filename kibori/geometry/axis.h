// SPDX-License-Identifier: MIT
// The direction of a dexel field as a type. Rays of axis a run along a; their feet lie on the (u,
// v) plane, where (a, u, v) is the cyclic permutation of (x, y, z) that starts at a.
#pragma once

#include <array>

#include <kibori/base/names.h>

namespace kibori {

enum class Axis { x = 0, y = 1, z = 2 };
constexpr Names<3> names_of(Axis) { return {"x", "y", "z"}; }
inline constexpr std::array<Axis, 3> kAxes = {Axis::x, Axis::y, Axis::z};

constexpr int depth_index(Axis axis) { return static_cast<int>(axis); }
constexpr int u_index(Axis axis) { return (static_cast<int>(axis) + 1) % 3; }
constexpr int v_index(Axis axis) { return (static_cast<int>(axis) + 2) % 3; }

}  // namespace kibori
