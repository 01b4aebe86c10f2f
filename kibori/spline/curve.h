// SPDX-License-Identifier: MIT
// Cubic B-spline curves that pass through or near control points.
//
// A curve is a function C of a parameter t. Its knots are at whole numbers t. An interpolating
// curve passes through point j at t = j. In a closed approximating curve, point j has its largest
// weight at t = j. Because the knots are uniform, a curve is linear in its points P_j at any t:
//
//   C(t) = sum over j of B_j(t) P_j.
//
// If point j moves, the curve moves by B_j(t) times this displacement. This would not be true if
// knots depended on chord lengths, because B would then depend on the points.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// The control points of a curve, and how the curve follows the points.
struct SplineCurve {
  std::vector<Vec3> points_mm;
  bool closed = false;
  // True: the curve passes through the points. An open curve then has no curvature at its ends.
  // False: the curve passes near the points. An open curve then goes from the first point to the
  // last.
  bool interpolate = true;
  bool operator==(const SplineCurve&) const = default;
};

inline constexpr size_t kMaxSplinePoints = 64;

// A curve as a polyline through samples of the curve. Lists have one entry for each sample.
struct FlatCurve {
  bool closed = false;  // true: the last sample is joined to the first
  std::vector<double> t;
  std::vector<Vec3> at_mm;
  std::vector<Vec3> tangent;  // dC/dt [mm]
  size_t points = 0;          // number of control points
  std::vector<double> weights;

  size_t samples() const { return t.size(); }
  // Returns the weight B of control point `point` at a sample.
  double weight(size_t sample, size_t point) const { return weights[sample * points + point]; }
};

// A curve that can be evaluated and flattened.
class CubicSpline {
 public:
  struct Point {
    Vec3 at_mm, first, second;  // C [mm], dC/dt, d2C/dt2
  };

  // Errors: fewer than 3 points of a closed curve, or than 2 of an open one; more than
  // kMaxSplinePoints; a coordinate that is not finite, or larger than kMaxCoordinate; all points in
  // one place; two successive points of an interpolating curve in one place. An open curve of 2
  // points is a straight line.
  static Result<CubicSpline> make(const SplineCurve& curve);

  bool closed() const { return closed_; }
  size_t points() const { return points_; }
  // A span is the curve between two knots. t is in [0, spans()]. Beyond this range, a closed curve
  // repeats, and an open one stays at its end.
  int spans() const { return spans_; }

  Point at(double t) const;
  // Returns B_j(t) of every control point j. Their sum is 1. In an interpolating curve, some may be
  // negative.
  std::vector<double> weights(double t) const;

  // Returns a polyline whose corners are on the curve. Its distance from the curve is at most the
  // tolerance, by the bound |C''| dt^2 / 8. (C'' is linear between knots.) Each span has at least
  // kMinSegments segments, so that weights are nearly linear between samples, too. A curve of two
  // points has one segment. Errors: a tolerance that is not above 0, or that needs more than
  // kMaxSamples samples.
  Result<FlatCurve> flatten(double tolerance_mm) const;

  static constexpr int kMinSegments = 4;
  static constexpr double kMaxSamples = 100'000;

 private:
  struct Basis {
    size_t span;
    double value[4], first[4], second[4];
  };
  CubicSpline(size_t points, bool closed, bool interpolate);
  Basis basis(double t) const;
  size_t coefficient(size_t span, size_t local) const;

  bool closed_;
  size_t points_;
  int spans_;
  Eigen::MatrixXd from_points_;  // row i: the weights of the control points in coefficient i
  std::vector<Vec3> coefficients_;
};

}  // namespace kibori
