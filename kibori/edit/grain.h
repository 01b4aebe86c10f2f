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
// It is evaluated for each removed piece of each ray, in parts no longer than a tenth of a ring.
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
  // Of u, on average over the piece [lo, hi) of the ray (u, v) [lattice units].
  double by_ring(uint8_t material, Axis axis, double u, double v, double lo, double hi) const;

 private:
  struct Kind {
    bool felt = false;
    double along = 1;  // u_along over u
    double ring = 0;
  };
  const Kind& kind(uint8_t material) const {
    return kinds_[std::min<size_t>(material, kinds_.size() - 1)];
  }
  double rings(const Vec3& units) const;

  Log log_;  // lattice units
  std::vector<Kind> kinds_;
  // ring_wave on a coarse grid of its own, as it changes slowly: asking it anew for every bit of
  // wood would take longer than the cut.
  Index3 count_;
  double step_ = 1;  // [lattice units]
  std::vector<float> waves_;
};

}  // namespace kibori
