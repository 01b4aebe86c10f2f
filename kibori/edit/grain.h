// SPDX-License-Identifier: MIT
// Wood as a tool feels it: how much more, or less, than its material's specific energy u it takes
// to remove a bit of it there, in that direction.
//
//   along or across   Hankinson: u(theta) = u_par u_perp / (u_par sin^2 + u_perp cos^2), theta
//   between
//                     the motion and the grain. u_perp is the material's u, u_par its u_along.
//   early or late     u (1 + ring (late_wood(x) - kMeanLate)): late wood of a ring resists more by
//                     the share `ring` than its early wood, and the wood as a whole as u says.
//
// It is evaluated for each removed piece of each ray, in parts no longer than a quarter of a ring.
// Over a part the rings are taken to be as wide as they are along the ray at its middle; the mean
// over them is exact.
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

// The mean of late_wood over a ring.
inline constexpr double kMeanLate = 0.125;

class Grain {
 public:
  // Of what was cut from the lattice's whole box; null: no material has a grain that is felt.
  static std::shared_ptr<const Grain> of(const Lattice& lattice,
                                         const std::vector<Material>& materials);

  // Of a log that lies as is said [mm, of the lattice's frame].
  Grain(const Log& log, const Lattice& lattice, const std::vector<Material>& materials);
  Grain(const Grain&) = delete;  // views_ points into it
  Grain& operator=(const Grain&) = delete;

  bool felt(uint8_t material) const { return kind(material).felt; }
  // sin^2 of the angle between a motion (any length) and the grain; across where it stands still.
  double across2(const Vec3& motion) const {
    const double size2 = motion.squaredNorm();
    if (!(size2 > 0)) return 1;
    const double along = motion.dot(log_.along);
    return 1 - along * along / size2;
  }
  // Of u: what it takes in that direction.
  double by_direction(uint8_t material, double across2) const {
    const double share = kind(material).along;
    return share / (share * across2 + (1 - across2));
  }
  // By what share of u late wood resists more; where it is 0, rings are not felt.
  double ring(uint8_t material) const { return kind(material).ring; }
  // The mean of late_wood over the piece [lo, hi) of each of `count` rays beside each other, of
  // which the first stands at (u, v) [lattice units]. `count`: a multiple of the vectors' lanes (16
  // is one); what a ray without a piece gets means nothing.
  void late_wood_of(Axis axis, float u, float v, const float* lo, const float* hi, size_t count,
                    float* means) const;

  // What late_wood_of needs of a field with that axis, in the order u, v, depth.
  struct View {
    float pith[3], along[3];  // lattice units
    float per_ring;           // rings a lattice unit
    float per_step;           // nodes of the waves' grid a lattice unit
    float last[3];            // its last cells
    int stride[3];
    const float* waves;
    // The share of early wood by year, from `first_year` on.
    const float* early;
    float first_year, last_year;
  };

 private:
  struct Kind {
    bool felt = false;
    double along = 1;  // u_along over u
    double ring = 0;
  };
  const Kind& kind(uint8_t material) const {
    return kinds_[std::min<size_t>(material, kinds_.size() - 1)];
  }

  Log log_;  // lattice units
  std::vector<Kind> kinds_;
  // ring_wave on a coarse grid of its own, as it changes slowly: asking it anew for every bit of
  // wood would take longer than the cut.
  std::vector<float> waves_;
  std::vector<float> early_;  // by year
  std::array<View, 3> views_;
};

}  // namespace kibori
