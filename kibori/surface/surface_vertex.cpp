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

}  // namespace

SheetVertex place_vertex(const SheetEnds& ends) {
  const Vec4f mean = ends.point_sum * (1 / static_cast<float>(ends.count));
  SheetVertex vertex{mean, Vec4f(0, 0, 1, 0), 1};
  const float length = std::sqrt(ends.normal_sum.squaredNorm());
  if (ends.with_normal == 0 || !(length > 1e-9f)) return vertex;
  vertex.normal = ends.normal_sum * (1 / length);

  if (one_face(ends, vertex.normal, length)) {
    // Along the mean normal alone.
    const float height = ends.products.sum() - ends.normal_sum.dot(mean);
    vertex.point = mean + (height / length) * vertex.normal;
  } else {
    Mat3 a = Mat3::Zero();
    Vec3 b = Vec3::Zero();
    for (int i = 0; i < ends.count; i++) {
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

}  // namespace kibori
