// SPDX-License-Identifier: MIT
// Sums over what an edit removed or added, for each material, in lattice units. The force models
// need only these sums, not the solid.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include <kibori/base/tolerances.h>
#include <kibori/geometry/axis.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// A set of lattice cells along one axis, in which something was removed. Indices of cells are
// modulo 256.
class CellSet {
 public:
  static constexpr int kCells = 256;
  // Adds the cells first .. first + 15 whose bits are set. `first` must be a multiple of 16.
  void add16(int first, unsigned bits) {
    words_[static_cast<size_t>(first >> 6) % 4] |= uint64_t{bits} << (first & 63);
  }
  void add(const CellSet& other) {
    for (size_t i = 0; i < 4; i++) words_[i] |= other.words_[i];
  }
  void clear() { words_ = {}; }
  // Returns, among the cells from the first to the last one of the set, the share that is not in
  // the set. Returns 0 if the set has fewer than two separate runs.
  double gaps() const;

 private:
  // Not initialised: a Removed has 192 sets, and most of them are never used.
  std::array<uint64_t, 4> words_;
};

// Sums over the removed part of one material. Positions are in lattice units from the lattice's
// origin. Volumes are in lattice units^3, as in dexel/volume.h.
struct RemovedPart {
  int64_t points;                   // number of lattice nodes
  std::array<int64_t, 3> node_sum;  // sums of the nodes' indices along x, y and z
  double correction;                // sum of the corrections of the ends of all fields
  Vec3 moment;                      // first moment of the volume about Motion::reference
  // Only valid if `weighted`, for wood with a grain (edit/grain.h): volume and moment, with
  // weights. The weight of an element is the ratio of its resistance to its material's u.
  bool weighted;
  double weighted_volume;
  Vec3 weighted_moment;
  bool turning;  // true: turn_ is valid
  // Sums over all elements dV, for a tool that turns. Let s be an element's displacement. It
  // resists with the force f = dV s/|s|^2.
  struct TurnSums {
    Vec3 force;   // f
    Vec3 moment;  // r x f, where r is the element's offset from Motion::reference
    // h e_z x f. e_z is the direction of the tool's axis, and h the height of the element along it.
    // For force laws of five degrees of freedom.
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

  bool has_chip;  // true: chip_ is valid
  // Sums that describe the shape of the chip (haptics/chip.h).
  struct ChipSums {
    // Second moments of the volume about Motion::reference: xx, yy, zz, xy, xz, yz.
    std::array<double, 6> second;
    // The front of the tool: sums over the ends that the tool made. `front` is the sum of
    // A max(0, n.p), and `front_normal` the sum of A max(0, n.p) n. A is the surface area that an
    // end represents. n is the tool's outward normal there, and p the direction of the motion.
    double front;
    Vec3 front_normal;
    // Volume that is computed from the lengths of the removed pieces. Motion::length_weights has
    // the weight of each field. The result is biased for thin cuts, but grows evenly as the tool
    // advances.
    double length;
    std::array<CellSet, 3> cells;  // along x, y and z
    // For a tool that turns: sums of dV/|s| and of |s| dV, where s is the displacement of the
    // element dV.
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

  // The removed volume. Over all edits, it adds up to the missing volume.
  double volume() const { return static_cast<double>(points) + correction; }
  // The removed volume and its first moment. For wood with a grain, each element is weighted by the
  // ratio of its resistance to its material's u.
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
  // sign: 1 adds the sums of `other`, -1 subtracts them.
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
  Removed() {}  // leaves parts_ uninitialised: clearing 64 parts in every tick takes too long

  bool has(int material) const { return (mask_ >> material) & 1; }
  const RemovedPart& part(int material) const { return parts_[static_cast<size_t>(material)]; }
  RemovedPart& part(int material) {
    if (!has(material)) {
      parts_[static_cast<size_t>(material)].clear();
      mask_ |= uint64_t{1} << material;
    }
    return parts_[static_cast<size_t>(material)];
  }
  // Calls f(material, part) for each material that has sums.
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
  // The cells along x, y and z in which something was removed, over all materials. Only edits that
  // compute chip sums store them.
  std::array<CellSet, 3> cells() const;
  int64_t points() const {
    int64_t sum = 0;
    for_parts([&](int, const RemovedPart& p) { sum += p.points; });
    return sum;
  }

  int64_t ends_painted = 0;
  bool clipped = false;  // true: a deposit reached beyond the lattice, and that part was dropped

 private:
  uint64_t mask_ = 0;
  std::array<RemovedPart, kMaxMaterials> parts_;  // valid if their bit in mask_ is set
};

}  // namespace kibori
