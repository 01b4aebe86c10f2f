// SPDX-License-Identifier: MIT
// The axis of a dexel field, as a type. The field's rays are parallel to its axis. The directions u
// and v follow the axis in the cyclic order x, y, z. For example, for axis y, u is z and v is x.
// The indices (u, v) identify a ray.
#pragma once

#include <array>
#include <cstddef>

#include <kibori/base/names.h>

namespace kibori {

enum class Axis { x = 0, y = 1, z = 2 };
constexpr Names<3> names_of(Axis) { return {"x", "y", "z"}; }
inline constexpr std::array<Axis, 3> kAxes = {Axis::x, Axis::y, Axis::z};

// Index of a vector's component along the rays of a field (depth), along u, and along v.
constexpr int depth_index(Axis axis) { return static_cast<int>(axis); }
constexpr int u_index(Axis axis) { return (static_cast<int>(axis) + 1) % 3; }
constexpr int v_index(Axis axis) { return (static_cast<int>(axis) + 2) % 3; }

// Renames the axes cyclically: axis `first` becomes x, the next one y, and the last one z. Fields
// get new names, too. In its renamed field, a ray keeps its (u, v), and a vector its (depth, u, v).
class AxisTurn {
 public:
  constexpr AxisTurn() = default;
  constexpr explicit AxisTurn(Axis first) : by_(static_cast<int>(first)) {}

  // The old name of the axis whose new name is `turned`.
  constexpr Axis old(Axis turned) const { return kAxes[static_cast<size_t>(index(turned))]; }
  // Converts a vector whose components are in the order of the old names to the order of the new
  // names (turn), and back (turn_back).
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
