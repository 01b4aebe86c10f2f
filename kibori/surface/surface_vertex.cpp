// SPDX-License-Identifier: MIT
#include <kibori/surface/surface_vertex.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include <kibori/geometry/vec.h>

namespace kibori {
namespace {

// Eigenvalues below this share of the largest are curvature and noise, not a second face. Two
// planes at an angle a give tan^2(a/2), so 0.05 keeps edges sharp above 25 degrees.
constexpr double kSharp = 0.05;
// Maximum distance of a point from a face that it counts as on [lattice units]. The curvature of
// the surface causes such distances.
constexpr float kTouching = 0.02f;
// Maximum distance of a vertex beyond one of its faces [lattice units]. It occurs if several faces
// do not meet in one point, as in a splinter thinner than a cell.
constexpr float kBeyond = 0.1f;
// A vertex that is nearer to the mean of its ends than this [lattice units] cannot be visibly
// beyond another face.
constexpr float kNear = 0.3f;

// True if all normals are within kFlat of their mean. `length` is the length of their sum.
bool one_face(const SheetEnds& ends, const Vec4f& normal, float length) {
  // The cosines of the normals to their mean add up to `length`. If the sum is nearly the number of
  // normals, no cosine is far below 1.
  if (length > static_cast<float>(ends.with_normal) - (1 - kFlat)) return true;
  float min = 1;
  for (int i = 0; i < ends.count; i++)
    if (ends.normals[i] != Vec4f::Zero()) min = std::min(min, ends.normals[i].dot(normal));
  return min > kFlat;
}

// 1: the faces bound a convex corner of the material; -1: of the empty space.
float side_of(const SheetVertex& vertex, const Vec4f& mean) {
  return (vertex.point - mean).dot(vertex.normal) > 0 ? 1.0f : -1.0f;
}

// True if no end is in front of another end's face: the faces bound one convex corner. Where the
// surface is rough, normals do not match their ends. There, the result is almost always false.
bool is_convex(const SheetEnds& ends, float side) {
  for (int i = 0; i < ends.count; i++)
    for (int j = 0; j < ends.count; j++)
      if (side * (ends.points[i] - ends.points[j]).dot(ends.normals[j]) > kTouching) return false;
  return true;
}

// Moves the vertex back towards the mean of the ends, if a face separates the two.
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

  if (ends.adjacent_faces == 0 && one_face(ends, vertex.normal, length)) {
    // Move along the mean normal only.
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
    // Eigenvalues ascend. The direct method is three times as fast as iteration, and accurate
    // enough for float32.
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
  // Move back towards the mean, which is inside the cell, until the vertex is within reach.
  float share = 1;
  for (int i = 0; i < 3; i++) {
    const float step = vertex.point[i] - mean[i];
    if (vertex.point[i] > kVertexReach) share = std::min(share, (kVertexReach - mean[i]) / step);
    if (vertex.point[i] < -kVertexReach) share = std::min(share, (-kVertexReach - mean[i]) / step);
  }
  vertex.point = mean + share * (vertex.point - mean);
  return vertex;
}

bool is_far(const SheetEnds& ends, const SheetVertex& vertex) {
  return vertex.rank > 1 && ends.distance_to(vertex.point) > kNear;
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
