// SPDX-License-Identifier: MIT
// The positions of a model's rays. Positions are in millimetres in the world (Vec3, Box), or in
// lattice units (LatticePoint, LatticeVector, LatticeBox). A lattice unit is one pitch. A Lattice
// converts between the two, and the types keep them apart.
#pragma once

#include <kibori/geometry/vec.h>

namespace kibori {

// A point in lattice units, from the lattice's lower corner.
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

// Nodes are at origin + (i + 1/2, j + 1/2, k + 1/2) * pitch, with i < nodes.x() and so on.
struct Lattice {
  Index3 nodes = Index3::Zero();
  Vec3 origin_mm = Vec3::Zero();  // lower corner of the lattice's box
  double pitch_mm = 1;            // between two rays

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
  // The whole lattice, from its lower corner to its upper one.
  LatticeBox whole() const { return {{Vec3::Zero(), nodes.matrix().cast<double>()}}; }
  int nodes_along(int index) const { return nodes[index]; }
};

}  // namespace kibori
