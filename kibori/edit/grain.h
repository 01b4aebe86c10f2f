// SPDX-License-Identifier: MIT
// Grain of wood: how a material's specific energy u changes with the position and the direction of
// a cut.
//
//   along or across   Hankinson: u(theta) = u_par u_perp / (u_par sin^2 + u_perp cos^2), theta
//                     between the motion and the grain. u_perp is the material's u, u_par its
//                     u_along.
//   early or late     u (1 + ring (late_wood(x) - kMeanLate)): late wood of a ring resists more
//                     than its early wood by the share `ring`. The mean over all wood is u.
//
// Each removed piece of a ray is divided into parts no longer than a quarter of a ring. In a part,
// the distance between rings along the ray is assumed to be constant: it is the one at the middle.
// Under this assumption, the mean of late_wood over the part is exact.
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
  // Grain of a stock that fills the lattice's base. Null if no material has a grain.
  static std::shared_ptr<const Grain> of(const Lattice& lattice,
                                         const std::vector<Material>& materials);

  // Grain of a given log [mm, in the lattice's frame].
  Grain(const Log& log, const Lattice& lattice, const std::vector<Material>& materials);
  Grain(const Grain&) = delete;  // views_ points into the object
  Grain& operator=(const Grain&) = delete;

  // Direction of the fibres, unit.
  const Vec3& fibre() const { return log_.along; }
  bool has_effect(uint8_t material) const { return kind(material).has_effect; }
  // sin^2 of the angle between a motion (of any length) and the grain; 1 without motion.
  double across2(const Vec3& motion) const {
    const double size2 = motion.squaredNorm();
    if (!(size2 > 0)) return 1;
    const double along = motion.dot(log_.along);
    return 1 - along * along / size2;
  }
  // Ratio of the resistance in a direction to u.
  double by_direction(uint8_t material, double across2) const {
    const double share = kind(material).along;
    return share / (share * across2 + (1 - across2));
  }
  // Share of u by which late wood resists more; 0: rings have no effect.
  double ring(uint8_t material) const { return kind(material).ring; }
  // Mean of late_wood over the piece [lo, hi) of each of `count` adjacent rays. The first ray is at
  // (u, v) [lattice units]. `count`: a multiple of the vectors' lanes, for example 16. The result
  // of a ray without a piece is undefined.
  void late_wood_of(Axis axis, float u, float v, const float* lo, const float* hi, size_t count,
                    float* means) const;

  // Data for late_wood_of, for the field of one axis. Coordinates are in the order u, v, depth.
  struct View {
    float pith[3], along[3];  // lattice units
    float per_ring;           // rings per lattice unit
    float per_step;           // nodes of the wave grid per lattice unit
    float last[3];            // index of the wave grid's last cell, along each axis
    int stride[3];
    const float* waves;
    // Share of early wood by year, starting with `first_year`.
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

  Log log_;  // lattice units
  std::vector<Kind> kinds_;
  // ring_wave, sampled on a coarse grid because it varies slowly. Evaluating it for every piece of
  // wood would take longer than the cut.
  std::vector<float> waves_;
  std::vector<float> early_;  // by year
  std::array<View, 3> views_;
};

}  // namespace kibori
