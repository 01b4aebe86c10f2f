// SPDX-License-Identifier: MIT
// What an edit took away (or put there), by material, in lattice units: enough to compute any of
// the force models without looking at the model again.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include <kibori/base/tolerances.h>
#include <kibori/geometry/axis.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// Sums over the removed part of one material. Positions are lattice coordinates (lattice units from
// the lattice's lower corner); volumes are lattice units^3.
struct RemovedPart {
  // By field (x, y, z): volume as that field measures it, and first moment about the reference
  // point.
  std::array<double, 3> volume;
  std::array<Vec3, 3> moment;
  int64_t points;                   // lattice nodes, decided by the z field
  std::array<int64_t, 3> node_sum;  // sums of their indices
  // Where wood is felt (edit/grain.h): the same sums, each bit as much as it resists, over its
  // material's u. Meaningful while `felt`.
  bool felt;
  // Whether these are of what the tool's surface passed (Motion::passing) instead of lengths. Let t
  // be when the surface passes a place, from 0 to 1, and s the tool's shift. As s . grad t = 1,
  // what is removed is the sum over the fields of the integral of s_i dt/dx_i: each piece of a ray
  // counts by s_i and how much later the surface passes its end than its beginning. The sum over
  // all three is the volume, each by itself is not. A face that lies along a field's rays removes a
  // whole row of them at once now and then; t is the same all along such a piece, so it does not
  // count.
  bool passed;
  std::array<double, 3> felt_volume;
  std::array<Vec3, 3> felt_moment;
  bool turning;  // whether there are turn sums
  struct TurnSums {
    // Every element resists against its own displacement s. By field, sums of f = dV w s/|s|^2 with
    // w = (component of s along the field's rays)^2 / |s|^2, of its moments about the reference
    // point, and of dV w.
    std::array<Vec3, 3> force;
    std::array<Vec3, 3> moment;       // r x f
    std::array<Vec3, 3> moment_axis;  // (height along the tool) e_z x f: the five-DOF part
    std::array<double, 3> volume;
  };
  const TurnSums& turn() const { return turn_; }  // meaningful while `turning`
  TurnSums& turn() {
    if (!turning) {
      const Vec3 o = Vec3::Zero();
      turn_ = {{o, o, o}, {o, o, o}, {o, o, o}, {0, 0, 0}};
      turning = true;
    }
    return turn_;
  }

  // What resists, over the material's u.
  double resisting(size_t field) const { return felt ? felt_volume[field] : volume[field]; }
  const Vec3& resisting_moment(size_t field) const {
    return felt ? felt_moment[field] : moment[field];
  }
  void feel() {
    if (felt) return;
    felt_volume = {0, 0, 0};
    felt_moment = {Vec3(Vec3::Zero()), Vec3(Vec3::Zero()), Vec3(Vec3::Zero())};
    felt = true;
    passed = false;
  }

  void clear() {
    volume = {0, 0, 0};
    moment = {Vec3(Vec3::Zero()), Vec3(Vec3::Zero()), Vec3(Vec3::Zero())};
    points = 0;
    node_sum = {0, 0, 0};
    felt = passed = false;
    turning = false;  // leaves turn_ alone
  }
  // sign: -1 takes the other's sums away.
  void add(const RemovedPart& other, int sign = 1) {
    for (size_t i = 0; i < 3; i++) {
      volume[i] += sign * other.volume[i];
      moment[i] += sign * other.moment[i];
      node_sum[i] += sign * other.node_sum[i];
    }
    points += sign * other.points;
    if (other.felt) {
      feel();
      passed |= other.passed;
      for (size_t i = 0; i < 3; i++) {
        felt_volume[i] += sign * other.felt_volume[i];
        felt_moment[i] += sign * other.felt_moment[i];
      }
    }
    if (!other.turning) return;
    TurnSums& sums = turn();
    for (size_t i = 0; i < 3; i++) {
      sums.force[i] += sign * other.turn_.force[i];
      sums.moment[i] += sign * other.turn_.moment[i];
      sums.moment_axis[i] += sign * other.turn_.moment_axis[i];
      sums.volume[i] += sign * other.turn_.volume[i];
    }
  }
  // Mean of the three fields; summed over edits it telescopes to exactly what is missing.
  double mean_volume() const { return (volume[0] + volume[1] + volume[2]) / 3; }

 private:
  TurnSums turn_;
};

class Removed {
 public:
  Removed() {}  // leaves parts_ alone: 64 parts are not cleared every tick

  bool has(int material) const { return (mask_ >> material) & 1; }
  const RemovedPart& part(int material) const { return parts_[static_cast<size_t>(material)]; }
  RemovedPart& part(int material) {
    if (!has(material)) {
      parts_[static_cast<size_t>(material)].clear();
      mask_ |= uint64_t{1} << material;
    }
    return parts_[static_cast<size_t>(material)];
  }
  // Calls f(material, part) for the materials present.
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

  double mean_volume() const {
    double sum = 0;
    for_parts([&](int, const RemovedPart& p) { sum += p.mean_volume(); });
    return sum;
  }
  int64_t points() const {
    int64_t sum = 0;
    for_parts([&](int, const RemovedPart& p) { sum += p.points; });
    return sum;
  }

  int64_t ends_painted = 0;
  bool clipped = false;  // a deposit reached beyond the lattice, and that part was dropped

 private:
  uint64_t mask_ = 0;
  std::array<RemovedPart, kMaxMaterials> parts_;  // meaningful where mask_ says so
};

}  // namespace kibori
