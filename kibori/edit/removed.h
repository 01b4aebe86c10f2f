// SPDX-License-Identifier: MIT
// Sums over what an edit removed or added, by material, in lattice units. Every force model needs
// only these sums, not the solid.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include <kibori/base/tolerances.h>
#include <kibori/geometry/axis.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// A set of indices, modulo 256: those of the lattice cells along one axis in which something was
// removed.
class CellSet {
 public:
  static constexpr int kCells = 256;
  // Adds the cells first .. first + 15 whose bits are set; `first` is a multiple of 16.
  void add16(int first, unsigned bits) {
    words_[static_cast<size_t>(first >> 6) % 4] |= uint64_t{bits} << (first & 63);
  }
  void add(const CellSet& other) {
    for (size_t i = 0; i < 4; i++) words_[i] |= other.words_[i];
  }
  void clear() { words_ = {}; }
  // Share of the cells between the first and the last that are not in the set. Returns 0 for fewer
  // than two separate runs.
  double gaps() const;

 private:
  // Not cleared by default: a Removed holds 192 sets, and most of them are never used.
  std::array<uint64_t, 4> words_;
};

// Sums over the removed part of one material. Positions are lattice coordinates (lattice units from
// the lattice's origin). Volumes are lattice units^3, as in dexel/volume.h.
struct RemovedPart {
  int64_t points;                   // number of lattice nodes
  std::array<int64_t, 3> node_sum;  // sums of their indices
  double correction;                // of the ends of all fields
  Vec3 moment;                      // first moment of the volume about Motion::reference
  // Wood with a grain (edit/grain.h): volume and moment, each element weighted by the ratio of its
  // resistance to its material's u. Valid if `weighted`.
  bool weighted;
  double weighted_volume;
  Vec3 weighted_moment;
  bool turning;  // there are turn sums
  // Sums over all elements dV. An element resists its own displacement s with f = dV s/|s|^2.
  struct TurnSums {
    Vec3 force;   // f
    Vec3 moment;  // r x f, r from Motion::reference
    // h e_z x f: e_z is the tool's axis, h the height of dV along it. For force laws of five DOF.
    Vec3 moment_axis;
  };
  const TurnSums& turn() const { return turn_; }  // valid if `turning`
  TurnSums& turn() {
    if (!turning) {
      turn_ = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
      turning = true;
    }
    return turn_;
  }

  bool has_chip;  // there are chip sums
  // For the shape of the chip (haptics/chip.h).
  struct ChipSums {
    // Second moments of the volume about Motion::reference: xx, yy, zz, xy, xz, yz.
    std::array<double, 6> second;
    // The front of the tool. `front` is the sum of A max(0, n.p) over the ends that the tool made.
    // `front_normal` is the sum of A max(0, n.p) n. A is the surface area that the end represents,
    // n the tool's outward normal, p the direction of the motion.
    double front;
    Vec3 front_normal;
    // Volume from the lengths of the rays, each field weighted by Motion::length_weights. It is
    // biased for thin cuts, but grows evenly as the tool advances.
    double length;
    std::array<CellSet, 3> cells;  // along x, y and z
    // Sums of dV/|s| and of |s| dV, where s is the displacement of the element dV, for a tool that
    // turns.
    double section, path_volume;
  };
  const ChipSums& chip() const { return chip_; }  // valid if `has_chip`
  ChipSums& chip() {
    if (!has_chip) {
      chip_ = {{}, 0, Vec3::Zero(), 0, {}, 0, 0};
      has_chip = true;
    }
    return chip_;
  }

  // The sum over edits equals the missing volume.
  double volume() const { return static_cast<double>(points) + correction; }
  // Volume weighted by the ratio of the resistance to the material's u, and its first moment.
  double resisting() const { return weighted ? weighted_volume : volume(); }
  const Vec3& resisting_moment() const { return weighted ? weighted_moment : moment; }
  void start_weighted_sums() {
    if (weighted) return;
    weighted_volume = 0;
    weighted_moment = Vec3::Zero();
    weighted = true;
  }

  void clear() {
    points = 0;
    node_sum = {0, 0, 0};
    correction = 0;
    moment = Vec3::Zero();
    weighted = turning = has_chip = false;  // does not clear turn_ and chip_
  }
  // sign: -1 subtracts the other's sums.
  void add(const RemovedPart& other, int sign = 1) {
    points += sign * other.points;
    for (size_t i = 0; i < 3; i++) node_sum[i] += sign * other.node_sum[i];
    correction += sign * other.correction;
    moment += sign * other.moment;
    if (other.weighted) {
      start_weighted_sums();
      weighted_volume += sign * other.weighted_volume;
      weighted_moment += sign * other.weighted_moment;
    }
    if (other.has_chip) {
      ChipSums& sums = chip();
      for (size_t i = 0; i < 6; i++) sums.second[i] += sign * other.chip_.second[i];
      sums.front += sign * other.chip_.front;
      sums.front_normal += sign * other.chip_.front_normal;
      sums.length += sign * other.chip_.length;
      for (size_t i = 0; i < 3; i++) sums.cells[i].add(other.chip_.cells[i]);
      sums.section += sign * other.chip_.section;
      sums.path_volume += sign * other.chip_.path_volume;
    }
    if (!other.turning) return;
    TurnSums& sums = turn();
    sums.force += sign * other.turn_.force;
    sums.moment += sign * other.turn_.moment;
    sums.moment_axis += sign * other.turn_.moment_axis;
  }

 private:
  TurnSums turn_;
  ChipSums chip_;
};

class Removed {
 public:
  Removed() {}  // does not clear parts_: clearing 64 parts every tick takes too long

  bool has(int material) const { return (mask_ >> material) & 1; }
  const RemovedPart& part(int material) const { return parts_[static_cast<size_t>(material)]; }
  RemovedPart& part(int material) {
    if (!has(material)) {
      parts_[static_cast<size_t>(material)].clear();
      mask_ |= uint64_t{1} << material;
    }
    return parts_[static_cast<size_t>(material)];
  }
  // Calls f(material, part) for each material that is present.
  template <class F>
  void for_parts(F&& f) const {
    for (uint64_t left = mask_; left; left &= left - 1) {
      const int material = std::countr_zero(left);
      f(material, part(material));
    }
  }
  void add(const Removed& other, int sign = 1) {
    other.for_parts([&](int material, const RemovedPart& p) { part(material).add(p, sign); });
    ends_painted += other.ends_painted;
    clipped |= other.clipped;
  }
  void reset() {
    mask_ = 0;
    ends_painted = 0;
    clipped = false;
  }

  double volume() const {
    double sum = 0;
    for_parts([&](int, const RemovedPart& p) { sum += p.volume(); });
    return sum;
  }
  // Chip sums: cells along x, y and z in which something was removed, over all materials.
  std::array<CellSet, 3> cells() const;
  int64_t points() const {
    int64_t sum = 0;
    for_parts([&](int, const RemovedPart& p) { sum += p.points; });
    return sum;
  }

  int64_t ends_painted = 0;
  bool clipped = false;  // a deposit reached beyond the lattice; that part was dropped

 private:
  uint64_t mask_ = 0;
  std::array<RemovedPart, kMaxMaterials> parts_;  // valid where mask_ is set
};

}  // namespace kibori
