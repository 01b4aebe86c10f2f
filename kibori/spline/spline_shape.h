// SPDX-License-Identifier: MIT
// Makes a solid shape from a spline. The profile is extruded along a direction or revolved about an
// axis, or a round section follows the curve. The result is a closed mesh with the shape's own
// normals. For forces (spline_force.h), the mesh stores for each vertex the sample of the curve
// with which it moves.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>
#include <kibori/spline/curve.h>

namespace kibori {

enum class SplineKind { extrude, revolve, sweep };
constexpr Names<3> names_of(SplineKind) { return {"extrude", "revolve", "sweep"}; }

// A shape: its kind, its curve, and the data of that kind.
struct SplineShape {
  SplineKind kind = SplineKind::sweep;
  SplineCurve curve;
  // For extrude: the curve is the profile. It must be planar. If it is open, a straight line closes
  // it. It is extruded by `length_mm` along the direction (of any length), which must not be in its
  // plane.
  Vec3 direction = Vec3::UnitZ();
  double length_mm = 10;
  // For revolve: a full turn about the axis (of any length). The ends of an open curve are joined
  // to the axis by perpendicular lines. If a curve is not in one plane with the axis, only its
  // distance from the axis and its height count.
  Vec3 axis_point_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
  // For sweep: the radius of the round section. An open curve ends in half balls. Parts of a sweep
  // that overlap are united.
  double radius_mm = 5;
  bool operator==(const SplineShape&) const = default;
};

// A shape as a mesh, with the data that forces need.
struct SplineMesh {
  TriangleMesh mesh;  // closed, counter-clockwise seen from outside
  // Per triangle, for each corner: the outward unit normal of the true shape.
  std::vector<std::array<Vec3, 3>> normals;
  FlatCurve curve;
  // Per vertex: the sample of the curve that it moves with. If the sample moves by x, the vertex
  // moves by carry x (by x if `carry` is empty).
  std::vector<uint32_t> sample;
  std::vector<Mat3> carry;
};

inline constexpr double kMaxSplineTriangles = 4e6;

// The shape as a mesh whose distance from it is at most the tolerance [mm]. Errors:
// - those of CubicSpline::make and flatten,
// - numbers that are not finite or not above 0,
// - an extruded profile that is not planar, or in a plane with its direction,
// - a profile that crosses itself or the axis, or touches the axis between its ends,
// - a sweep whose radius exceeds the bend radius of its curve,
// - more triangles than kMaxSplineTriangles.
Result<SplineMesh> make_spline_mesh(const SplineShape& shape, double tolerance_mm);

}  // namespace kibori
