// SPDX-License-Identifier: MIT
#include <kibori/spline/curve.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <kibori/base/tolerances.h>

namespace kibori {
namespace {

// Points closer than this share of the curve's extent are in one place. With a larger value, fine
// detail of a large curve would be rejected. With a smaller one, the curve's direction there would
// be rounding error.
constexpr double kOnePlace = 1e-9;

// Solves matrix x = right in place, without pivots. These systems are diagonally dominant or nearly
// so. The solver only combines whole rows and computes no sums, so the vector unit does not change
// the result.
void solve(Eigen::MatrixXd& matrix, Eigen::MatrixXd& right) {
  const Eigen::Index n = matrix.rows();
  const auto combine = [&](Eigen::Index into, Eigen::Index from) {
    const double factor = matrix(into, from) / matrix(from, from);
    if (factor == 0) return;
    matrix.row(into) -= factor * matrix.row(from);
    right.row(into) -= factor * right.row(from);
  };
  for (Eigen::Index k = 0; k < n; k++)
    for (Eigen::Index i = k + 1; i < n; i++) combine(i, k);
  for (Eigen::Index k = n; k-- > 0;) {
    for (Eigen::Index i = 0; i < k; i++) combine(i, k);
    right.row(k) /= matrix(k, k);
  }
}

}  // namespace

CubicSpline::CubicSpline(size_t points, bool closed, bool interpolate)
    : closed_(closed), points_(points) {
  const auto n = static_cast<Eigen::Index>(points);
  spans_ = static_cast<int>(closed        ? points
                            : interpolate ? points - 1
                                          : std::max<size_t>(points, 4) - 3);
  if (!interpolate) {
    from_points_ = Eigen::MatrixXd::Identity(n, n);
    if (closed || points >= 4) return;
    // A line or a parabola, as a cubic.
    from_points_ = Eigen::MatrixXd::Zero(4, n);
    from_points_(0, 0) = from_points_(3, n - 1) = 1;
    const double near = n == 2 ? 2 / 3.0 : 1 / 3.0;
    from_points_(1, 0) = from_points_(2, n - 1) = near;
    from_points_(1, 1) = from_points_(2, n - 2) = 1 - near;
    return;
  }
  const Eigen::Index rows = closed ? n : n + 2;
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(rows, rows);
  from_points_ = Eigen::MatrixXd::Zero(rows, n);
  const auto set_row = [&](Eigen::Index row, Eigen::Index knot, bool second) {
    const Basis b = basis(static_cast<double>(knot));
    for (size_t c = 0; c < 4; c++)
      system(row, static_cast<Eigen::Index>(coefficient(b.span, c))) +=
          second ? b.second[c] : b.value[c];
  };
  for (Eigen::Index j = 0; j < n; j++) {
    const Eigen::Index row = closed || j == 0 ? j : j == n - 1 ? n + 1 : j + 1;
    set_row(row, j, false);
    from_points_(row, j) = 1;
  }
  if (!closed) {  // no second derivative at the ends
    set_row(1, 0, true);
    set_row(n, n - 1, true);
  }
  solve(system, from_points_);
}

size_t CubicSpline::coefficient(size_t span, size_t local) const {
  return closed_ ? (span + local + points_ - 1) % points_ : span + local;
}

// The recursion of Cox and de Boor, from degree 1 to 3, between the eight knots around the span.
CubicSpline::Basis CubicSpline::basis(double t) const {
  const double end = spans_;
  t = closed_ ? t - end * std::floor(t / end) : std::clamp(t, 0.0, end);
  Basis b;
  const int span = std::clamp(static_cast<int>(t), 0, spans_ - 1);
  b.span = static_cast<size_t>(span);
  double k[8];
  for (int i = 0; i < 8; i++) {
    k[i] = span - 3 + i;
    if (!closed_) k[i] = std::clamp(k[i], 0.0, end);
  }
  const double one[2] = {k[4] - t, t - k[3]};
  double two[3], two_first[3];
  for (int j = 0; j < 3; j++) {
    two[j] = two_first[j] = 0;
    if (j > 0) {
      const double share = one[j - 1] / (k[3 + j] - k[1 + j]);
      two[j] += (t - k[1 + j]) * share;
      two_first[j] += 2 * share;
    }
    if (j < 2) {
      const double share = one[j] / (k[4 + j] - k[2 + j]);
      two[j] += (k[4 + j] - t) * share;
      two_first[j] -= 2 * share;
    }
  }
  for (int j = 0; j < 4; j++) {
    b.value[j] = b.first[j] = b.second[j] = 0;
    if (j > 0) {
      const double width = k[3 + j] - k[j];
      b.value[j] += (t - k[j]) * two[j - 1] / width;
      b.first[j] += 3 * two[j - 1] / width;
      b.second[j] += 3 * two_first[j - 1] / width;
    }
    if (j < 3) {
      const double width = k[4 + j] - k[1 + j];
      b.value[j] += (k[4 + j] - t) * two[j] / width;
      b.first[j] -= 3 * two[j] / width;
      b.second[j] -= 3 * two_first[j] / width;
    }
  }
  return b;
}

Result<CubicSpline> CubicSpline::make(const SplineCurve& curve) {
  const std::vector<Vec3>& points = curve.points_mm;
  const size_t min_count = curve.closed ? 3 : 2;
  if (points.size() < min_count)
    return Error{std::string(curve.closed ? "a closed" : "an open") + " spline needs at least " +
                 std::to_string(min_count) + " points, not " + std::to_string(points.size())};
  if (points.size() > kMaxSplinePoints)
    return Error{"a spline has at most " + std::to_string(kMaxSplinePoints) + " points, not " +
                 std::to_string(points.size())};
  Box box;
  for (size_t j = 0; j < points.size(); j++) {
    if (!(points[j].array().abs() <= kMaxCoordinate).all())
      return Error{"point " + std::to_string(j + 1) +
                   " of the spline is not finite, or too far away"};
    box.include(points[j]);
  }
  const double extent = box.size().norm();
  if (!(extent > 0)) return Error{"all points of the spline are in one place"};
  if (curve.interpolate)
    for (size_t j = curve.closed ? 0 : 1; j < points.size(); j++) {
      const size_t before = j == 0 ? points.size() - 1 : j - 1;
      if (!((points[j] - points[before]).norm() > kOnePlace * extent))
        return Error{"points " + std::to_string(before + 1) + " and " + std::to_string(j + 1) +
                     " of the spline are in one place"};
    }
  CubicSpline spline(points.size(), curve.closed, curve.interpolate);
  for (Eigen::Index i = 0; i < spline.from_points_.rows(); i++) {
    Vec3 sum = Vec3::Zero();
    for (size_t j = 0; j < points.size(); j++)
      sum += spline.from_points_(i, static_cast<Eigen::Index>(j)) * points[j];
    spline.coefficients_.push_back(sum);
  }
  return spline;
}

CubicSpline::Point CubicSpline::at(double t) const {
  const Basis b = basis(t);
  Point point{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (size_t c = 0; c < 4; c++) {
    const Vec3& of = coefficients_[coefficient(b.span, c)];
    point.at_mm += b.value[c] * of;
    point.first += b.first[c] * of;
    point.second += b.second[c] * of;
  }
  return point;
}

std::vector<double> CubicSpline::weights(double t) const {
  const Basis b = basis(t);
  std::vector<double> weights(points_, 0.0);
  for (size_t c = 0; c < 4; c++) {
    const auto row = static_cast<Eigen::Index>(coefficient(b.span, c));
    for (size_t j = 0; j < points_; j++)
      weights[j] += b.value[c] * from_points_(row, static_cast<Eigen::Index>(j));
  }
  return weights;
}

Result<FlatCurve> CubicSpline::flatten(double tolerance_mm) const {
  if (!(tolerance_mm > 0) || !std::isfinite(tolerance_mm))
    return Error{"a spline's tolerance must be above 0 mm"};
  std::vector<double> segments(static_cast<size_t>(spans_));
  double samples = 0;
  for (int span = 0; span < spans_; span++) {
    // C'' is linear between knots, so its maximum is at one of the two.
    const double bend = std::max(at(span).second.norm(), at(span + 1).second.norm());
    const double min_count = points_ == 2 ? 1 : kMinSegments;
    double& count = segments[static_cast<size_t>(span)];
    count = std::max(min_count, std::ceil(std::sqrt(bend / (8 * tolerance_mm))));
    samples += count;
  }
  if (!(samples <= kMaxSamples))
    return Error{"the spline is too large for this pitch; use a larger pitch"};
  FlatCurve flat;
  flat.closed = closed_;
  flat.points = points_;
  const auto add = [&](double t) {
    const Point point = at(t);
    flat.t.push_back(t);
    flat.at_mm.push_back(point.at_mm);
    flat.tangent.push_back(point.first);
    const std::vector<double> of = weights(t);
    flat.weights.insert(flat.weights.end(), of.begin(), of.end());
  };
  for (int span = 0; span < spans_; span++) {
    const double count = segments[static_cast<size_t>(span)];
    for (double i = 0; i < count; i++) add(span + i / count);
  }
  if (!closed_) add(spans_);
  return flat;
}

}  // namespace kibori
