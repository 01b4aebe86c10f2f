// SPDX-License-Identifier: MIT
// Makes a solid shape from a spline. There are three kinds of shapes. `extrude`: the curve is a
// profile, which is extruded along a direction. `revolve`: the profile is revolved about an axis.
// `sweep`: a round section follows the curve. The result is a closed mesh with the normals of the
// true shape. For forces (spline_force.h), the mesh stores the sample of the curve with which each
// vertex moves.
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

// A shape: its kind, its curve, and the data of its kind.
struct SplineShape {
  SplineKind kind = SplineKind::sweep;
  SplineCurve curve;
  // For extrude: the curve is the profile, which must be planar. If the profile is open, a straight
  // line closes it. The profile is extruded by `length_mm` along `direction`. The direction may
  // have any length, but must not be in the profile's plane.
  Vec3 direction = Vec3::UnitZ();
  double length_mm = 10;
  // For revolve: the curve makes a full turn about the axis. `axis` may have any length.
  // Perpendicular lines join the ends of an open curve to the axis. For each point of the curve,
  // only its distance from the axis and its height along the axis count.
  Vec3 axis_point_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
  // For sweep: the radius of the round section. An open curve ends in half balls. Parts of the
  // sweep that overlap are united.
  double radius_mm = 5;
  bool operator==(const SplineShape&) const = default;
};

// A shape as a mesh, with the data that forces need.
struct SplineMesh {
  TriangleMesh mesh;  // closed; counter-clockwise seen from outside
  // For each triangle and each corner: the outward unit normal of the true shape.
  std::vector<std::array<Vec3, 3>> normals;
  FlatCurve curve;
  // For each vertex: the sample of the curve with which the vertex moves. If the sample moves by x,
  // the vertex moves by carry x. If `carry` is empty, it moves by x.
  std::vector<uint32_t> sample;
  std::vector<Mat3> carry;
};

inline constexpr double kMaxSplineTriangles = 4e6;

// Returns the shape as a mesh. The distance between mesh and shape is at most the tolerance [mm].
// Errors:
// - those of CubicSpline::make and flatten,
// - numbers that are not finite or not above 0,
// - an extruded profile that is not planar, or whose plane contains the direction,
// - a profile that crosses itself or the axis, or touches the axis between its ends,
// - a sweep whose radius exceeds the bend radius of its curve,
// - more triangles than kMaxSplineTriangles.
Result<SplineMesh> make_spline_mesh(const SplineShape& shape, double tolerance_mm);

}  // namespace kibori
