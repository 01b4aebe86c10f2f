// SPDX-License-Identifier: MIT
// The direction of a dexel field as a type. The rays of axis a are parallel to a. A ray is
// identified by its indices (u, v). (a, u, v) is the cyclic permutation of (x, y, z) that starts at
// a.
#pragma once

#include <array>
#include <cstddef>

#include <kibori/base/names.h>

namespace kibori {

enum class Axis { x = 0, y = 1, z = 2 };
constexpr Names<3> names_of(Axis) { return {"x", "y", "z"}; }
inline constexpr std::array<Axis, 3> kAxes = {Axis::x, Axis::y, Axis::z};

// The component of a vector along a field's rays, and those along u and v.
constexpr int depth_index(Axis axis) { return static_cast<int>(axis); }
constexpr int u_index(Axis axis) { return (static_cast<int>(axis) + 1) % 3; }
constexpr int v_index(Axis axis) { return (static_cast<int>(axis) + 2) % 3; }

// Renames the axes cyclically: `first` becomes x, the next y, and the last z. A ray keeps its (u,
// v), and a vector its (depth, u, v).
class AxisTurn {
 public:
  constexpr AxisTurn() = default;
  constexpr explicit AxisTurn(Axis first) : by_(static_cast<int>(first)) {}

  // The old name of an axis.
  constexpr Axis old(Axis turned) const { return kAxes[static_cast<size_t>(index(turned))]; }
  // Converts a vector's components from old names to new ones, and back.
  template <class Vector>
  Vector turn(const Vector& by_old) const {
    Vector turned;
    for (const Axis axis : kAxes) turned[depth_index(axis)] = by_old[index(axis)];
    return turned;
  }
  template <class Vector>
  Vector turn_back(const Vector& turned) const {
    Vector by_old;
    for (const Axis axis : kAxes) by_old[index(axis)] = turned[depth_index(axis)];
    return by_old;
  }

 private:
  constexpr int index(Axis turned) const { return (static_cast<int>(turned) + by_) % 3; }

  int by_ = 0;
};

}  // namespace kibori
