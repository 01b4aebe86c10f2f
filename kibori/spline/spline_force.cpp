// SPDX-License-Identifier: MIT
#include <kibori/spline/spline_force.h>

#include <cmath>

#include <kibori/base/check.h>

namespace kibori {
namespace {

// The integral of |f| over a triangle, from its area and f at its corners. f is linear.
double integral_of_size(double area, double a, double b, double c) {
  const double whole = area * (a + b + c) / 3;
  // The corner that is alone on its side of zero. Its part of the triangle is a smaller triangle.
  double alone = a, one = b, two = c;
  if ((b < 0) != (a < 0) && (b < 0) != (c < 0)) {
    alone = b;
    one = a;
  } else if ((c < 0) != (a < 0) && (c < 0) != (b < 0)) {
    alone = c;
    two = a;
  }
  if ((alone < 0) == (one < 0) || alone == 0) return std::abs(whole);
  const double part = area / 3 * alone * (alone / (alone - one)) * (alone / (alone - two));
  return std::abs(part) + std::abs(whole - part);
}

}  // namespace

std::vector<SplineVolumeChange> spline_volume_changes(const SplineMesh& shape,
                                                      const std::vector<Vec3>& displacements_mm) {
  KIBORI_CHECK(displacements_mm.size() == shape.curve.points);
  std::vector<SplineVolumeChange> changes(displacements_mm.size());
  for (const auto& triangle : shape.mesh.triangles) {
    const auto& at = shape.mesh.vertices;
    // Twice the area, along the normal.
    const Vec3 normal =
        (at[triangle[1]] - at[triangle[0]]).cross(at[triangle[2]] - at[triangle[0]]);
    const double area = 0.5 * std::sqrt(normal.squaredNorm());
    if (!(area > 0)) continue;
    Vec3 across[3];  // times the sample's displacement: displacement of the vertex along the normal
    for (size_t i = 0; i < 3; i++) {
      across[i] = normal / (2 * area);
      if (!shape.carry.empty()) across[i] = shape.carry[triangle[i]].transpose() * across[i];
    }
    for (size_t j = 0; j < changes.size(); j++) {
      if (displacements_mm[j].isZero(0)) continue;
      double f[3];
      for (size_t i = 0; i < 3; i++)
        f[i] =
            shape.curve.weight(shape.sample[triangle[i]], j) * across[i].dot(displacements_mm[j]);
      if (f[0] == 0 && f[1] == 0 && f[2] == 0) continue;
      changes[j].net_mm3 += area * (f[0] + f[1] + f[2]) / 3;
      changes[j].moved_mm3 += integral_of_size(area, f[0], f[1], f[2]);
    }
  }
  return changes;
}

std::vector<Vec3> spline_forces(const SplineMesh& shape, const std::vector<Vec3>& displacements_mm,
                                double u) {
  const std::vector<SplineVolumeChange> changes = spline_volume_changes(shape, displacements_mm);
  std::vector<Vec3> forces;
  for (size_t j = 0; j < changes.size(); j++) {
    const double distance2 = displacements_mm[j].squaredNorm();
    forces.push_back(distance2 > 0
                         ? Vec3(-u * changes[j].moved_mm3 / distance2 * displacements_mm[j])
                         : Vec3(Vec3::Zero()));
  }
  return forces;
}

}  // namespace kibori
