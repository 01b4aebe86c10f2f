// SPDX-License-Identifier: MIT
// Plane polygons: whether one crosses itself, and its triangles. Internal to `spline`.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace kibori {

using Vec2 = Eigen::Vector2d;

// Above 0 where the polygon goes round counter-clockwise.
double signed_area(const std::vector<Vec2>& polygon);

// Whether sides of a closed polygon cross or touch, other than neighbours in their corner.
bool crosses_itself(const std::vector<Vec2>& polygon);

// Triangles of a counter-clockwise polygon that does not cross itself, by cutting ears (Meisters
// 1975), in turn around it so that they do not all become slivers of one corner.
std::vector<std::array<uint32_t, 3>> triangulate(const std::vector<Vec2>& polygon);

}  // namespace kibori
