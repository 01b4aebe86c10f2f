// SPDX-License-Identifier: MIT
// The grain of wood: how a material's specific cutting energy changes with the position and the
// direction of a cut.
//
//   along or across   u(theta) = u_par u_perp / (u_par sin^2 theta + u_perp cos^2 theta). theta is
//                     the angle between motion and grain. u_perp is the material's u, and u_par
//                     its u_along (Hankinson).
//   early or late     u (1 + ring (late_wood - kMeanLate)). In a year's ring, late wood resists
//                     more than early wood by the share `ring` of u. The mean of all wood is u.
//
// Each removed piece of a ray is divided into parts. A part is no longer than a quarter of a ring.
// The formulas assume that in a part, the distance between rings along the ray is constant: it is
// the distance at the part's middle. Under this assumption, the mean of late_wood over the part is
// exact.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <kibori/geometry/axis.h>
#include <kibori/geometry/lattice.h>
#include <kibori/geometry/material.h>
#include <kibori/geometry/wood.h>

namespace kibori {

// Mean of late_wood over a ring.
inline constexpr double kMeanLate = 0.125;

class Grain {
 public:
  // Returns the grain of a stock that fills the lattice's base. Null if no material has a grain.
  static std::shared_ptr<const Grain> of(const Lattice& lattice,
                                         const std::vector<Material>& materials);

  // The grain of a given log [mm, in the lattice's frame].
  Grain(const Log& log, const Lattice& lattice, const std::vector<Material>& materials);
  Grain(const Grain&) = delete;  // views_ points into the object
  Grain& operator=(const Grain&) = delete;

  // Direction of the fibres, as a unit vector.
  const Vec3& fibre() const { return log_.along; }
  bool has_effect(uint8_t material) const { return kind(material).has_effect; }
  // Returns sin^2 of the angle between a motion and the grain. The motion may have any length.
  // Without motion, the result is 1.
  double across2(const Vec3& motion) const {
    const double size2 = motion.squaredNorm();
    if (!(size2 > 0)) return 1;
    const double along = motion.dot(log_.along);
    return 1 - along * along / size2;
  }
  // Returns the ratio of the resistance in a direction to u. `across2` is the result of across2().
  double by_direction(uint8_t material, double across2) const {
    const double share = kind(material).along;
    return share / (share * across2 + (1 - across2));
  }
  // Late wood resists more than early wood by this share of u. 0: rings have no effect.
  double ring(uint8_t material) const { return kind(material).ring; }
  // Computes the mean of late_wood over the piece [lo, hi) of each of `count` rays that are
  // adjacent along u. The first ray is at (u, v) [lattice units]. `count` must be a multiple of the
  // number of lanes in a vector, for example 16. The result of a ray without a piece is undefined.
  void late_wood_of(Axis axis, float u, float v, const float* lo, const float* hi, size_t count,
                    float* means) const;

  // Data for late_wood_of in one field. Arrays are in the order u, v, depth. The wave grid has
  // ring_wave (geometry/wood.h) at the nodes of a coarse grid.
  struct View {
    float pith[3], along[3];  // lattice units
    float per_ring;           // rings per lattice unit
    float per_step;           // nodes of the wave grid per lattice unit
    float last[3];            // index of the wave grid's last cell, along each axis
    int stride[3];
    const float* waves;
    // Share of early wood in the rings of the years from first_year to last_year.
    const float* early;
    float first_year, last_year;
  };

 private:
  struct Kind {
    bool has_effect = false;
    double along = 1;  // ratio of u_along to u
    double ring = 0;
  };
  const Kind& kind(uint8_t material) const {
    return kinds_[std::min<size_t>(material, kinds_.size() - 1)];
  }

  Log log_;  // its pith and ring are in lattice units
  std::vector<Kind> kinds_;
  // The wave grid. ring_wave varies slowly, so a coarse grid is enough. Its evaluation for every
  // piece would take longer than the cut.
  std::vector<float> waves_;
  std::vector<float> early_;  // share of early wood by year
  std::array<View, 3> views_;
};

}  // namespace kibori
