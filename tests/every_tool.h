// SPDX-License-Identifier: MIT
// For every tool shape: a function that makes a tool that passes check_tool, and a function for the
// points that the tool contains. The second one uses only the definition of the shape. It is the
// oracle of sweeps. If a shape is missing, the tests do not compile.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <variant>

#include <kibori/solid/tool.h>

namespace kibori::test {

// Sizes of a tool [mm]. A blade is two radii wide.
struct ToolSize {
  double radius, length;
};

// For each shape, in the order of Tool:
//   make    a tool of that size, longer if the shape needs it. draw(min, usual, max) gives a number
//           between min and max. Draw one number at a time: compilers differ in the order in which
//           they evaluate the arguments of a function.
//   inside  >= 0 at points inside. Near the surface it is roughly the distance from it [mm]. Points
//           are in the tool's frame.

template <class Shape>
using Of = std::type_identity<Shape>;

inline double from_axis(const Vec3& p) { return std::hypot(p.x(), p.y()); }
inline double radians(double degrees) { return degrees * std::acos(-1.0) / 180; }

Finger make(Of<Finger>, const ToolSize& size, auto&& draw) {
  return {draw(0.3, 1, 2) / size.radius, size.length};
}
inline double inside(const Finger& t, const Vec3& p) {
  const double r = from_axis(p);
  return std::min((p.z() - t.ks * r * r) / std::hypot(1, 2 * t.ks * r), t.length - p.z());
}

BallTool make(Of<BallTool>, const ToolSize& size, auto&&) { return {size.radius}; }
inline double inside(const BallTool& t, const Vec3& p) {
  return t.radius - (p - Vec3(0, 0, t.radius)).norm();
}

Flat make(Of<Flat>, const ToolSize& size, auto&&) { return {size.radius, size.length}; }
inline double inside(const Flat& t, const Vec3& p) {
  return std::min({t.radius - from_axis(p), p.z(), t.length - p.z()});
}

Bull make(Of<Bull>, const ToolSize& size, auto&& draw) {
  const double corner = draw(0.1, 1.0 / 3, 1) * size.radius;
  return {size.radius, corner, std::max(size.length, 2.1 * corner)};
}
inline double inside(const Bull& t, const Vec3& p) {
  const double r = from_axis(p), inner = t.radius - t.corner;
  if (r > inner && p.z() < t.corner) return t.corner - std::hypot(r - inner, t.corner - p.z());
  return std::min({t.radius - r, p.z(), t.length - p.z()});
}

Cone make(Of<Cone>, const ToolSize& size, auto&& draw) {
  return {draw(15, 90, 150), size.radius, size.length};
}
inline double inside(const Cone& t, const Vec3& p) {
  const double half = radians(t.angle_deg) / 2, r = from_axis(p);
  return std::min({p.z() * std::sin(half) - r * std::cos(half), t.radius - r, t.length - p.z()});
}

Capsule make(Of<Capsule>, const ToolSize& size, auto&&) {
  return {size.radius, std::max(size.length, 2.1 * size.radius)};
}
inline double inside(const Capsule& t, const Vec3& p) {
  const double z = std::clamp(p.z(), t.radius, t.length - t.radius);
  return t.radius - (p - Vec3(0, 0, z)).norm();
}

HalfSpace make(Of<HalfSpace>, const ToolSize&, auto&&) { return {}; }
inline double inside(const HalfSpace&, const Vec3& p) { return p.z(); }

BoxTool make(Of<BoxTool>, const ToolSize& size, auto&& draw) {
  const double breadth = draw(0.2, 2, 4) * size.radius;
  return {Vec3(2 * size.radius, breadth, size.length)};
}
inline double inside(const BoxTool& t, const Vec3& p) {
  return std::min({t.size.x() / 2 - std::abs(p.x()), t.size.y() / 2 - std::abs(p.y()), p.z(),
                   t.size.z() - p.z()});
}

Ellipsoid make(Of<Ellipsoid>, const ToolSize& size, auto&& draw) {
  const double y = draw(0.3, 0.7, 1.5) * size.radius, z = draw(0.3, 1, 1.5) * size.radius;
  return {Vec3(size.radius, y, z)};
}
inline double inside(const Ellipsoid& t, const Vec3& p) {
  const Vec3 q = (p - Vec3(0, 0, t.radii.z())).cwiseQuotient(t.radii);
  return (1 - q.norm()) * t.radii.minCoeff();
}

// A tetrahedron without a plane of symmetry.
MeshTool make(Of<MeshTool>, const ToolSize& size, auto&& draw) {
  auto mesh = std::make_shared<TriangleMesh>();
  const double s = 2 * size.radius, side = draw(0, 0.1, 0.2) * s;
  mesh->vertices = {{0, 0, 0}, {s, 0, 0.1 * s}, {0, s, 0.2 * s}, {side, 0.1 * s, size.length}};
  mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return {mesh};
}
// The mesh must be convex.
inline double inside(const MeshTool& tool, const Vec3& p) {
  double min = 1e30;
  for (const auto& t : tool.mesh->triangles) {
    const Vec3 &a = tool.mesh->vertices[t[0]], &b = tool.mesh->vertices[t[1]],
               &c = tool.mesh->vertices[t[2]];
    min = std::min(min, -(p - a).dot((b - a).cross(c - a).normalized()));
  }
  return min;
}

Drill make(Of<Drill>, const ToolSize& size, auto&& draw) {
  return {draw(60, 118, 150), size.radius, size.length};
}
inline double inside(const Drill& t, const Vec3& p) {
  return inside(Cone{t.angle_deg, t.radius, t.length}, p);
}

// Includes balls as wide as the shank, and tapers that end before they reach the shank's width.
TaperedBall make(Of<TaperedBall>, const ToolSize& size, auto&& draw) {
  const double ball = std::min(1.0, draw(0.2, 1.0 / 3, 1.2)) * size.radius;
  return {ball, draw(3, 40, 140), size.radius, std::max(size.length, 2.1 * ball)};
}
// A cone with a rounded tip. The distance is measured from the ball's centre. If the side of the
// cone is nearest, it is measured along the side's normal, otherwise along the line to the point.
inline double inside(const TaperedBall& t, const Vec3& p) {
  const double half = radians(t.angle_deg) / 2, r = from_axis(p), z = p.z() - t.ball;
  const bool near_side = z * std::cos(half) > -r * std::sin(half);
  const double side =
      near_side ? t.ball + z * std::sin(half) - r * std::cos(half) : t.ball - std::hypot(r, z);
  return std::min({side, t.radius - r, t.length - p.z()});
}

// The inside of a blade's box, without its cutting edge.
inline double inside_blade(const auto& t, const Vec3& p) {
  return std::min(
      {t.thickness / 2 - std::abs(p.x()), t.width / 2 - std::abs(p.y()), t.length - p.z()});
}

Gouge make(Of<Gouge>, const ToolSize& size, auto&& draw) {
  return {std::floor(draw(2, 7, 11.99)), 2 * size.radius, draw(0.1, 0.125, 0.5) * size.radius,
          size.length};
}
inline double inside(const Gouge& t, const Vec3& p) {
  const GougeArc arc = gouge_arc(t);
  const double y = p.y() / arc.across, z = 1 - p.z() / arc.upright;
  // The value of the ellipse's function divided by its gradient. If the gradient is zero, no face
  // is near.
  const double slope = std::hypot(y / arc.across, z / arc.upright);
  const double below = p.z() >= arc.depth ? 1e30
                       : slope > 1e-6     ? (1 - y * y - z * z) / (2 * slope)
                                          : 1e30;
  return std::min(below, inside_blade(t, p));
}

Vee make(Of<Vee>, const ToolSize& size, auto&& draw) {
  return {draw(15, 90, 150), 2 * size.radius, draw(0.1, 0.125, 0.5) * size.radius, size.length};
}
inline double inside(const Vee& t, const Vec3& p) {
  const double half = radians(t.angle_deg) / 2;
  return std::min(p.z() * std::sin(half) - std::abs(p.y()) * std::cos(half), inside_blade(t, p));
}

Chisel make(Of<Chisel>, const ToolSize& size, auto&& draw) {
  return {2 * size.radius, draw(10, 25, 110), draw(0.1, 0.25, 0.8) * size.radius, size.length};
}
inline double inside(const Chisel& t, const Vec3& p) {
  const double half = radians(t.bevel_deg) / 2;
  return std::min(p.z() * std::sin(half) - std::abs(p.x()) * std::cos(half), inside_blade(t, p));
}

Skew make(Of<Skew>, const ToolSize& size, auto&& draw) {
  const double skew = draw(2, 30, 60), bevel = draw(15, 25, 110),
               thickness = draw(0.1, 0.25, 0.8) * size.radius;
  const double bevels = 2 * size.radius * std::tan(radians(skew)) +
                        thickness / 2 / std::tan(radians(bevel) / 2) / std::cos(radians(skew));
  return {2 * size.radius, skew, bevel, thickness, std::max(size.length, 1.01 * bevels)};
}
inline double inside(const Skew& t, const Vec3& p) {
  const double half = radians(t.bevel_deg) / 2, skew = radians(t.skew_deg);
  const double up = p.z() * std::cos(skew) - p.y() * std::sin(skew);
  return std::min({up * std::sin(half) - std::abs(p.x()) * std::cos(half),
                   t.thickness / 2 - std::abs(p.x()), p.y(), t.width - p.y(), t.length - p.z()});
}

Knife make(Of<Knife>, const ToolSize& size, auto&& draw) {
  return {draw(5, 20, 110), draw(10, 60, 140), std::min(size.length, 4 * size.radius)};
}
inline double inside(const Knife& t, const Vec3& p) {
  const double edge = radians(t.edge_deg) / 2, point = radians(t.point_deg) / 2;
  const double up = p.z() * std::sin(point) - std::abs(p.x()) * std::cos(point);
  return std::min(up * std::sin(edge) - std::abs(p.y()) * std::cos(edge), t.length - p.z());
}

// The inside of the neck and the shank. The neck begins at the height `from`, within the head.
inline double inside_stem(const auto& t, double from, const Vec3& p) {
  const double r = from_axis(p);
  return std::max(std::min({t.neck - r, p.z() - from, t.length - p.z()}),
                  std::min({t.shank - r, p.z() - t.reach, t.length - p.z()}));
}

Lollipop make(Of<Lollipop>, const ToolSize& size, auto&& draw) {
  const double neck = draw(0.2, 1.0 / 3, 1) * size.radius,
               reach = std::max(size.length, 2 * size.radius);
  return {size.radius, neck, reach, draw(1, 1.5, 3) * neck, draw(1, 1.5, 2) * reach};
}
inline double inside(const Lollipop& t, const Vec3& p) {
  return std::max(t.radius - (p - Vec3(0, 0, t.radius)).norm(), inside_stem(t, t.radius, p));
}

TSlot make(Of<TSlot>, const ToolSize& size, auto&& draw) {
  const double height = draw(0.1, 0.5, 1.5) * size.radius,
               neck = draw(0.2, 1.0 / 3, 1) * size.radius, reach = std::max(size.length, height);
  return {size.radius, height, neck, reach, draw(1, 1.5, 3) * neck, draw(1, 1.5, 2) * reach};
}
inline double inside(const TSlot& t, const Vec3& p) {
  return std::max(std::min({t.radius - from_axis(p), p.z(), t.height - p.z()}),
                  inside_stem(t, t.height / 2, p));
}

inline double inside(const Tool& tool, const Vec3& p) {
  return std::visit([&](const auto& t) { return inside(t, p); }, tool);
}

// `shape` is an index into kToolShapes.
Tool make_tool(size_t shape, const ToolSize& size, auto&& draw) {
  return std::visit([&]<class Shape>(const Shape&) { return Tool(make(Of<Shape>(), size, draw)); },
                    *default_tool(kToolShapes[shape]));
}

// A tool in its usual proportions.
inline Tool usual_tool(size_t shape, const ToolSize& size) {
  return make_tool(shape, size, [](double, double usual, double) { return usual; });
}

struct ToolSizes {  // [mm]
  double min_radius, max_radius, min_length, max_length;
};

// `random` gives uniform(low, high) and integer(low, high).
Tool random_tool(size_t shape, auto& random, const ToolSizes& sizes) {
  const double radius = random.uniform(sizes.min_radius, sizes.max_radius),
               length = random.uniform(sizes.min_length, sizes.max_length);
  return make_tool(shape, {radius, length},
                   [&](double min, double, double max) { return random.uniform(min, max); });
}

inline const size_t kMeshShape = Tool(MeshTool()).index();

// True if a shape has numbers that describe it. Meshes and the half-space have none.
inline bool has_numbers(size_t shape) {
  bool has = false;
  for_tool_numbers(*default_tool(kToolShapes[shape]),
                   [&](const char*, const auto&) { has = true; });
  return has;
}

// A tool of a random shape that has numbers. Draws only from the first `shapes` shapes. To repeat a
// seed, pass the number of shapes at the time when the seed was noted.
Tool random_tool(auto& random, const ToolSizes& sizes, size_t shapes = kToolShapes.size()) {
  for (;;) {
    const auto shape = static_cast<size_t>(random.integer(0, static_cast<int>(shapes) - 1));
    if (has_numbers(shape)) return random_tool(shape, random, sizes);
  }
}

}  // namespace kibori::test
