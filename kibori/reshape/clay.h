// SPDX-License-Identifier: MIT
// Clay at constant volume: what a tool presses away comes back around it (Sato et al., on bodies of
// any shape).
//
//            tool
//          \      /                       the surface around the tool rises:
//     __....\    /....__  <- collar       phi - lambda w
//   --       \__/       --
//            dent
//
//   w = falloff(|x - c| / R) * min(1, distance to the tool / kRamp)
//
// with the one lambda that adds the wanted volume, measured as the mean of the three fields. At the
// tool w is 0, so that nothing comes into its place.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/reshape/brush.h>
#include <kibori/reshape/node_band.h>
#include <kibori/solid/tool.h>

namespace kibori {

// Raises collars, and keeps its memory from one to the next. For one thread at a time.
class Clay {
 public:
  // The surface within `radius_mm` of `centre_mm` rises until `volume_mm3` was added, or as far as
  // one collar goes: kMaxRise at its highest, and no farther than the lattice. `tools`: poses where
  // the tool stands, and where nothing rises. Errors: a place, radius or volume that is not finite,
  // a region that there is no memory for.
  Result<Reshaped> raise(TriDexel& model, const Tool& tool, std::span<const Pose> tools,
                         const Vec3& centre_mm, double radius_mm, double volume_mm3);

  // Distance from the tool [cells] at which the collar has its whole height, and the most that one
  // collar rises [cells]: less than kRamp, so that what rises does not pass what stays.
  static constexpr double kRamp = 4, kMaxRise = 3;

 private:
  void measure_tool(const Tool& tool, std::span<const Pose> tools, const Lattice& lattice,
                    const NodeBox& box);

  NodeBand band_, tool_band_;
  // The tools alone, on a lattice of their own.
  std::unique_ptr<TriDexel> scratch_;
  Snapshot empty_;
  std::vector<float> after_, weights_;
  std::vector<uint32_t> touched_;
};

}  // namespace kibori
