// SPDX-License-Identifier: MIT
// What a spline makes: its profile pushed along a direction, turned about an axis, or a round
// section led along it; as a closed mesh with the shape's own normals. Every corner of the mesh
// knows the curve's sample that it goes along with, for forces (spline_force.h).
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

struct SplineShape {
  SplineKind kind = SplineKind::sweep;
  SplineCurve curve;
  // Of extrude: the curve, which must be planar, is the profile, closed by its chord if it is open.
  // It goes `length_mm` along the direction (any length), which is not in its plane.
  Vec3 direction = Vec3::UnitZ();
  double length_mm = 10;
  // Of revolve: a full turn about the axis (any length). An open curve is closed by the feet of its
  // ends on the axis. A curve that is not in one plane with the axis is taken by its distance from
  // the axis and its height.
  Vec3 axis_point_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
  // Of sweep: of the round section; an open curve ends in half balls. A sweep that meets itself
  // further on is joined to itself.
  double radius_mm = 5;
  bool operator==(const SplineShape&) const = default;
};

struct SplineMesh {
  TriangleMesh mesh;  // closed, counter-clockwise seen from outside
  // Of each triangle's corners: unit normals of the true shape, out of it.
  std::vector<std::array<Vec3, 3>> normals;
  FlatCurve curve;
  // By vertex: the sample of the curve that it goes along with; and where the sample goes by x, the
  // vertex goes by carry x (empty: by x).
  std::vector<uint32_t> sample;
  std::vector<Mat3> carry;
};

inline constexpr double kMaxSplineTriangles = 4e6;

// The shape as a mesh whose distance from it is at most the tolerance [mm]. Errors: those of
// CubicSpline::make and flatten; numbers that are not finite or not above 0; an extruded profile
// that is not planar, or in a plane with its direction; a profile that crosses itself or the axis,
// or touches the axis between its ends; a sweep that is thicker than its curve is bent; more
// triangles than kMaxSplineTriangles.
Result<SplineMesh> make_spline_mesh(const SplineShape& shape, double tolerance_mm);

}  // namespace kibori
