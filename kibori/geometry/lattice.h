// SPDX-License-Identifier: MIT
// The lattice of nodes through which a model's rays run. Positions are in millimetres (Vec3, Box)
// or in lattice units (LatticePoint, LatticeVector, LatticeBox). One lattice unit is one pitch. The
// types prevent mixing the two units. A Lattice converts between them.
#pragma once

#include <kibori/geometry/vec.h>

namespace kibori {

// A point in lattice units. The lattice's origin has the coordinates 0.
struct LatticePoint {
  Vec3 units = Vec3::Zero();

  double operator[](int index) const { return units[index]; }
};

// A displacement in lattice units.
struct LatticeVector {
  Vec3 units = Vec3::Zero();

  double operator[](int index) const { return units[index]; }
};

inline LatticePoint operator+(const LatticePoint& from, const LatticeVector& by) {
  return {from.units + by.units};
}

inline LatticeVector operator-(const LatticePoint& to, const LatticePoint& from) {
  return {to.units - from.units};
}

// A box in lattice units.
struct LatticeBox {
  Box units;

  bool empty() const { return units.empty(); }
  void include(const LatticeBox& other) { units.include(other.units); }
  LatticePoint centre() const { return {units.centre()}; }
};

// Node (i, j, k) is at origin + (i + 1/2, j + 1/2, k + 1/2) * pitch, for low() <= (i, j, k)
// < high(). A lattice can grow on all sides. Its base is what it was before it grew:
//
//        -below        0                     nodes       nodes + above
//          |   grown   |        base           |    grown    |
//                      origin
//
// Growth does not change the origin, so all nodes keep their indices and their positions.
struct Lattice {
  Index3 nodes = Index3::Zero();  // number of nodes of the base along x, y, z
  Vec3 origin_mm = Vec3::Zero();  // lower corner of the base
  double pitch_mm = 1;            // distance between adjacent nodes
  // Number of nodes that growth added along x, y, z: at the low sides and at the high sides
  // (dexel/tri_dexel.h).
  Index3 below = Index3::Zero(), above = Index3::Zero();

  Index3 low() const { return -below; }
  Index3 high() const { return nodes + above; }
  bool grown() const { return (below != 0).any() || (above != 0).any(); }

  LatticePoint to_lattice(const Vec3& point_mm) const {
    return {(point_mm - origin_mm) / pitch_mm};
  }
  LatticeBox to_lattice(const Box& box_mm) const {
    return {{to_lattice(box_mm.min).units, to_lattice(box_mm.max).units}};
  }
  LatticeVector vector_to_lattice(const Vec3& vector_mm) const {
    return {vector_mm * (1 / pitch_mm)};
  }
  Vec3 to_mm(const LatticePoint& point) const { return origin_mm + pitch_mm * point.units; }
  Box to_mm(const LatticeBox& box) const {
    return {to_mm(LatticePoint{box.units.min}), to_mm(LatticePoint{box.units.max})};
  }
  Vec3 vector_to_mm(const LatticeVector& vector) const { return pitch_mm * vector.units; }
  // The boxes of the whole lattice and of its base.
  LatticeBox whole() const {
    return {{low().matrix().cast<double>(), high().matrix().cast<double>()}};
  }
  LatticeBox base() const { return {{Vec3::Zero(), nodes.matrix().cast<double>()}}; }
};

}  // namespace kibori
