// SPDX-License-Identifier: MIT
// Cubic B-spline curves through or near control points.
//
// Knots are uniform. An interpolating curve passes point j at t = j. In a closed approximating
// curve, point j has its largest weight there. Because knots are uniform, a curve is linear in its
// points at any t:
//
//   C(t) = sum over j of B_j(t) P_j.
//
// If point j moves, the curve moves by B_j(t) times this displacement. If knots depended on chord
// lengths, B would depend on the points, and this would not be true.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// The control points of a curve, and how it follows them.
struct SplineCurve {
  std::vector<Vec3> points_mm;
  bool closed = false;
  // True: the curve passes through the points. If it is open, it has no curvature at its ends.
  // False: it passes near the points. If it is open, it goes from the first point to the last.
  bool interpolate = true;
  bool operator==(const SplineCurve&) const = default;
};

inline constexpr size_t kMaxSplinePoints = 64;

// A curve as a polyline.
struct FlatCurve {
  bool closed = false;  // if true, the last sample is joined to the first
  std::vector<double> t;
  std::vector<Vec3> at_mm;
  std::vector<Vec3> tangent;  // dC/dt [mm]
  size_t points = 0;          // control points
  std::vector<double> weights;

  size_t samples() const { return t.size(); }
  // B of control point `point` at a sample.
  double weight(size_t sample, size_t point) const { return weights[sample * points + point]; }
};

// A curve that can be evaluated and flattened.
class CubicSpline {
 public:
  struct Point {
    Vec3 at_mm, first, second;  // C [mm], dC/dt, d2C/dt2
  };

  // Errors: fewer than 3 points (2 if open: a straight line), or more than kMaxSplinePoints. Also
  // coordinates that are not finite or larger than kMaxCoordinate. Also all points in one place, or
  // two successive points of an interpolating curve in one place.
  static Result<CubicSpline> make(const SplineCurve& curve);

  bool closed() const { return closed_; }
  size_t points() const { return points_; }
  // t is in [0, spans()]. Beyond that, a closed curve repeats, and an open one stays at its end.
  int spans() const { return spans_; }

  Point at(double t) const;
  // B_j(t) of every control point. Their sum is 1. Those of an interpolating curve may be negative.
  std::vector<double> weights(double t) const;

  // A polyline whose corners are on the curve, and whose distance from it is at most the tolerance.
  // The bound is |C''| dt^2 / 8, where C'' is linear between knots. Each span has at least
  // kMinSegments segments, so that weights are nearly linear between samples too. A straight line
  // of two points has one segment. Errors: a tolerance that is not above 0, or one that needs more
  // than kMaxSamples.
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
  Eigen::MatrixXd from_points_;  // row i: weights of the control points in coefficient i
  std::vector<Vec3> coefficients_;
};

}  // namespace kibori
