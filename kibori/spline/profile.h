// SPDX-License-Identifier: MIT
// Plane polygons: a test for self-intersection, and triangulation. Internal to `spline`.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace kibori {

using Vec2 = Eigen::Vector2d;

// Returns the area [square of the input's unit]. It is positive if the polygon is
// counter-clockwise.
double signed_area(const std::vector<Vec2>& polygon);

// True if two sides of a closed polygon cross or touch. Neighbours may touch in their common
// corner.
bool crosses_itself(const std::vector<Vec2>& polygon);

// Divides a polygon into triangles by ear clipping (Meisters 1975). The polygon must be
// counter-clockwise and must not cross itself. The function clips ears in turn around the polygon.
// Otherwise many slivers could meet at one corner.
std::vector<std::array<uint32_t, 3>> triangulate(const std::vector<Vec2>& polygon);

}  // namespace kibori
