// SPDX-License-Identifier: MIT
// Clay at constant volume: the material that a tool displaces returns around it (Sato et al., for
// bodies of any shape).
//
//            tool
//          \      /                       the surface around the tool rises:
//     __....\    /....__  <- collar       phi - lambda w
//   --       \__/       --
//            dent
//
//   w = falloff(|x - c| / R) * clamp(distance to the sweep / kRamp, 0, 1)
//
// Lambda is chosen so that the wanted volume is added (dexel/volume.h). The volume is measured from
// the spans. With a tolerance of 5e-3 or more, it is estimated from the distances at nodes. The
// sweep is the tool, swept forward and back by R along its motion and out along its axis. Nothing
// rises in the sweep: a furrow stays open behind the tool, no wave forms in front of it, and
// nothing closes over it.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/reshape/brush.h>
#include <kibori/reshape/node_band.h>
#include <kibori/solid/tool.h>

namespace kibori {

// A pressing tool. `direction`: unit vector of its motion, or 0 if it only turns. `middle_mm`:
// centre of the material that it displaced last.
struct PressingTool {
  Pose pose;
  Vec3 direction = Vec3::Zero();
  Vec3 middle_mm = Vec3::Zero();
};

class WriteBack;

// Raises collars, and reuses its memory for the next one. One thread at a time.
class Clay {
 public:
  Clay();
  ~Clay();
  // Number of threads for a collar; results do not depend on it.
  void set_threads(int threads) {
    threads_ = threads;
    band_.set_threads(threads);
    path_band_.set_threads(threads);
  }
  // Raises the surface within `radius_mm` of the centre of `tools[of]` until `volume_mm3` is added.
  // A negative volume lowers it. `tolerance`: permitted error, as a share of the volume. From 5e-3
  // on, the error may be a few percent larger: see WriteBack::rough_volume. One collar rises by at
  // most kMaxRise, and not beyond the lattice. Nothing rises in the sweep of any of the tools. The
  // volume has steps as a function of the rise. If the wanted volume is inside a step, the nearer
  // side of the step is used. Errors: a position, radius or volume that is not finite; not enough
  // memory for the region.
  Result<Reshaped> raise(TriDexel& model, const Tool& tool, std::span<const PressingTool> tools,
                         size_t of, double radius_mm, double volume_mm3, double tolerance);

  // Memory of the largest collar so far [bytes].
  size_t kept_bytes() const { return kBytesPerNode * band_.phi().capacity(); }

  // kRamp: distance from the sweep [cells] at which the collar has its full height. kMaxRise:
  // maximum rise of one collar [cells]. The rise is less than kRamp, so that rising nodes do not
  // pass fixed ones.
  static constexpr double kRamp = 4, kMaxRise = 3;
  // Bytes of bands and weights per node of a collar.
  static constexpr size_t kBytesPerNode = 40;

 private:
  void measure_path(const Tool& tool, std::span<const PressingTool> tools, double radius_mm,
                    const Lattice& lattice, const NodeBox& box);
  bool find_touched(const NodeBox& all, const LatticePoint& centre, double radius, float core);
  double weigh(const LatticePoint& centre, double radius);
  bool rise(const TriDexel& model, double wanted, double area, double max_rise, double tolerance);

  int threads_ = 1;
  NodeBand band_, path_band_;
  // The sweeps of the tools only, on their own lattice.
  std::unique_ptr<TriDexel> scratch_;
  Snapshot empty_;
  NodeValues after_;
  std::vector<NodeBlock> touched_;
  std::unique_ptr<WriteBack> writer_;
  std::vector<detail::FloatRow> weights_;  // of each block's nodes
  std::vector<double> areas_;              // of each block's surface, weighted
};

}  // namespace kibori
