// SPDX-License-Identifier: MIT
#include <kibori/surface/surface_vertex.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace kibori {
namespace {

// Eigenvalues below this share of the largest are taken for curvature and noise, not for a second face: two
// planes at an angle a give tan^2(a/2), so 0.05 keeps edges sharper than 25 degrees.
constexpr double kSharp = 0.05;

}  // namespace

SheetVertex place_vertex(const SheetEnds& ends) {
  Vec3 mean = Vec3::Zero(), sum = Vec3::Zero();
  for (int i = 0; i < ends.count; i++) {
    mean += ends.points[i];
    sum += ends.normals[i];
  }
  mean /= ends.count;
  SheetVertex vertex{mean, Vec3::UnitZ(), 1};
  const double length = std::sqrt(sum.squaredNorm());
  if (ends.with_normal == 0 || !(length > 1e-9)) return vertex;
  vertex.normal = sum / length;

  // Nearly one plane: move along the mean normal alone.
  double along = 0, spread = 1, height = 0;
  for (int i = 0; i < ends.count; i++) {
    const Vec3& n = ends.normals[i];
    if (n == Vec3::Zero()) continue;
    const double c = n.dot(vertex.normal);
    along += c;
    spread = std::min(spread, c);
    height += n.dot(ends.points[i] - mean);
  }
  if (spread > 0.98) {
    vertex.point = mean + (height / along) * vertex.normal;
  } else {
    Mat3 a = Mat3::Zero();
    Vec3 b = Vec3::Zero();
    for (int i = 0; i < ends.count; i++) {
      const Vec3& n = ends.normals[i];
      a += n * n.transpose();
      b += n.dot(ends.points[i] - mean) * n;
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(a);  // ascending
    Vec3 step = Vec3::Zero();
    vertex.rank = 0;
    for (int i = 0; i < 3; i++) {
      const double value = solver.eigenvalues()[i];
      if (!(value > kSharp * solver.eigenvalues()[2])) continue;
      const Vec3 axis = solver.eigenvectors().col(i);
      step += (axis.dot(b) / value) * axis;
      vertex.rank++;
    }
    vertex.point = mean + step;
  }
  // Back towards the mean, which is inside the cell, until it is within reach.
  double share = 1;
  for (int i = 0; i < 3; i++) {
    const double step = vertex.point[i] - mean[i];
    if (mean[i] + step > kVertexReach) share = std::min(share, (kVertexReach - mean[i]) / step);
    if (mean[i] + step < -kVertexReach) share = std::min(share, (-kVertexReach - mean[i]) / step);
  }
  if (share < 1) vertex.point = mean + share * (vertex.point - mean);
  return vertex;
}

}  // namespace kibori
