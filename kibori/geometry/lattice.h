// SPDX-License-Identifier: MIT
// The positions of a model's rays. Positions are in millimetres in the world (Vec3, Box), or in
// lattice units (LatticePoint, LatticeVector, LatticeBox). A lattice unit is one pitch. A Lattice
// converts between the two, and the types keep them apart.
#pragma once

#include <kibori/geometry/vec.h>

namespace kibori {

// A point in lattice units, from the lattice's origin.
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

// Nodes are at origin + (i + 1/2, j + 1/2, k + 1/2) * pitch, with low() <= (i, j, k) < high().
//
//        -below        0                     nodes       nodes + above
//          |   grown   |        base           |    grown    |
//                      origin
//
// A lattice that grows keeps its origin, so all nodes keep their indices and their places.
struct Lattice {
  Index3 nodes = Index3::Zero();  // of the base: the lattice before it grew
  Vec3 origin_mm = Vec3::Zero();  // lower corner of the base
  double pitch_mm = 1;            // between two rays
  // Nodes that growth added on the sides (dexel/tri_dexel.h).
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
  // The box of the whole lattice, and that of its base.
  LatticeBox whole() const {
    return {{low().matrix().cast<double>(), high().matrix().cast<double>()}};
  }
  LatticeBox base() const { return {{Vec3::Zero(), nodes.matrix().cast<double>()}}; }
};

}  // namespace kibori
