// SPDX-License-Identifier: MIT
#include <kibori/surface/surface_vertex.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include <kibori/geometry/vec.h>

namespace kibori {
namespace {

// Eigenvalues below this share of the largest are taken for curvature and noise, not for a second
// face: two planes at an angle a give tan^2(a/2), so 0.05 keeps edges sharper than 25 degrees.
constexpr double kSharp = 0.05;
// How far a place may be off a face that it is on [lattice units]: what curvature makes of planes.
constexpr float kTouching = 0.02f;
// How far a vertex may be beyond one of its own faces [lattice units]: what several that do not
// meet in one place make of it, as those of a splinter thinner than a cell.
constexpr float kBeyond = 0.1f;
// Nearer to the mean of its ends [lattice units] a vertex passes no face that would show.
constexpr float kNear = 0.3f;

// Whether all normals are within kFlat of their mean, of length `length` before it was made a unit
// vector.
bool one_face(const SheetEnds& ends, const Vec4f& normal, float length) {
  // Their cosines add up to `length`, so if that is nearly their number, none is far below 1.
  if (length > static_cast<float>(ends.with_normal) - (1 - kFlat)) return true;
  float min = 1;
  for (int i = 0; i < ends.count; i++)
    if (ends.normals[i] != Vec4f::Zero()) min = std::min(min, ends.normals[i].dot(normal));
  return min > kFlat;
}

// 1: the faces bound a convex corner of the material; -1: of what is without.
float side_of(const SheetVertex& vertex, const Vec4f& mean) {
  return (vertex.point - mean).dot(vertex.normal) > 0 ? 1.0f : -1.0f;
}

// Whether no end lies in front of another's face: the faces bound one convex corner. Normals that
// are not those of their ends, as at a torn rim, hardly ever do.
bool is_convex(const SheetEnds& ends, float side) {
  for (int i = 0; i < ends.count; i++)
    for (int j = 0; j < ends.count; j++)
      if (side * (ends.points[i] - ends.points[j]).dot(ends.normals[j]) > kTouching) return false;
  return true;
}

// Back towards the mean of the ends, as far as it is beyond a face that the mean is not.
void hold_within(const SheetEnds& ends, const Vec4f& mean, SheetVertex& vertex) {
  const float side = side_of(vertex, mean);
  float share = 1;
  for (int i = 0; i < ends.planes(); i++) {
    const float beyond = side * (vertex.point - ends.points[i]).dot(ends.normals[i]);
    const float inside = -side * (mean - ends.points[i]).dot(ends.normals[i]);
    if (beyond > kBeyond && inside >= 0) share = std::min(share, inside / (inside + beyond));
  }
  if (share < 1 && is_convex(ends, side)) vertex.point = mean + share * (vertex.point - mean);
}

}  // namespace

SheetVertex place_vertex(const SheetEnds& ends) {
  const Vec4f mean = ends.mean();
  SheetVertex vertex{mean, Vec4f(0, 0, 1, 0), 1};
  const float length = std::sqrt(ends.normal_sum.squaredNorm());
  if (ends.with_normal == 0 || !(length > 1e-9f)) return vertex;
  vertex.normal = ends.normal_sum * (1 / length);

  if (ends.faces_beside == 0 && one_face(ends, vertex.normal, length)) {
    // Along the mean normal alone.
    const float height = ends.products.sum() - ends.normal_sum.dot(mean);
    vertex.point = mean + (height / length) * vertex.normal;
  } else {
    Mat3 a = Mat3::Zero();
    Vec3 b = Vec3::Zero();
    for (int i = 0; i < ends.planes(); i++) {
      const Vec3 n = ends.normals[i].head<3>().cast<double>();
      a += n * n.transpose();
      b += n.dot((ends.points[i] - mean).head<3>().cast<double>()) * n;
    }
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    // Ascending; three times as quick as by iteration, and exact enough for float32.
    solver.computeDirect(a);
    Vec3 step = Vec3::Zero();
    vertex.rank = 0;
    for (int i = 0; i < 3; i++) {
      const double value = solver.eigenvalues()[i];
      if (!(value > kSharp * solver.eigenvalues()[2])) continue;
      const Vec3 axis = solver.eigenvectors().col(i);
      step += (axis.dot(b) / value) * axis;
      vertex.rank++;
    }
    vertex.point.head<3>() += step.cast<float>();
    hold_within(ends, mean, vertex);
  }
  if (vertex.point.cwiseAbs().maxCoeff() <= kVertexReach) return vertex;
  // Back towards the mean, which is inside the cell, until it is within reach.
  float share = 1;
  for (int i = 0; i < 3; i++) {
    const float step = vertex.point[i] - mean[i];
    if (vertex.point[i] > kVertexReach) share = std::min(share, (kVertexReach - mean[i]) / step);
    if (vertex.point[i] < -kVertexReach) share = std::min(share, (-kVertexReach - mean[i]) / step);
  }
  vertex.point = mean + share * (vertex.point - mean);
  return vertex;
}

bool goes_far(const SheetEnds& ends, const SheetVertex& vertex) {
  return vertex.rank > 1 && ends.way_to(vertex.point) > kNear;
}

float passes(const SheetEnds& ends, const SheetVertex& vertex, const Vec4f& point,
             const Vec4f& normal) {
  const Vec4f mean = ends.mean();
  const float side = side_of(vertex, mean);
  const float beyond = side * (vertex.point - point).dot(normal);
  if (!(beyond > kTouching)) return 0;
  for (int i = 0; i < ends.planes(); i++)
    if (side * (point - ends.points[i]).dot(ends.normals[i]) > kTouching) return 0;
  return beyond;
}

}  // namespace kibori
