// SPDX-License-Identifier: MIT
// Plane polygons: a test for self-intersection, and triangulation. Internal to `spline`.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace kibori {

using Vec2 = Eigen::Vector2d;

// Positive if the polygon is counter-clockwise [square of the input's unit].
double signed_area(const std::vector<Vec2>& polygon);

// True if sides of a closed polygon cross or touch, except neighbours in their common corner.
bool crosses_itself(const std::vector<Vec2>& polygon);

// Divides a counter-clockwise polygon that does not cross itself into triangles, by ear clipping
// (Meisters 1975). It clips ears in turn around the polygon. Otherwise many slivers could meet at
// one corner.
std::vector<std::array<uint32_t, 3>> triangulate(const std::vector<Vec2>& polygon);

}  // namespace kibori
