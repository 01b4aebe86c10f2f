// SPDX-License-Identifier: MIT
// Clay at constant volume: the material that a tool displaces returns around the tool, as a collar
// (Sato et al., for bodies of any shape).
//
//            tool
//          \      /                       the surface around the tool rises:
//     __....\    /....__  <- collar       phi - lambda w
//   --       \__/       --
//            dent
//
//   w = falloff(|x - c| / R) * clamp(distance to the sweep / kRamp, 0, 1)
//
// c is the centre of the collar, R its radius, and falloff the smooth one of brush.h. Lambda is
// chosen so that the collar adds the wanted volume (dexel/volume.h). The volume is measured from
// the spans. If the tolerance is 5e-3 or more, it is estimated from the distances at nodes. The
// sweep consists of the tool, moved by R forward and back along its motion, and by R out along its
// axis. Nothing rises in the sweep. So a furrow stays open behind the tool, no wave forms in front
// of it, and no material closes over it.
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

// A tool that presses the clay. `direction` is the unit vector of its motion, or 0 if it only
// turns. `middle_mm` is the centre of the material that the tool displaced last.
struct PressingTool {
  Pose pose;
  Vec3 direction = Vec3::Zero();
  Vec3 middle_mm = Vec3::Zero();
};

class WriteBack;

// Raises collars. Keeps its memory for the next collar. One thread may use it at a time.
class Clay {
 public:
  Clay();
  ~Clay();
  // Sets the number of threads for a collar. It does not change the result.
  void set_threads(int threads) {
    threads_ = threads;
    band_.set_threads(threads);
    path_band_.set_threads(threads);
  }
  // Raises the surface within `radius_mm` of `tools[of].middle_mm` until `volume_mm3` is added. A
  // negative volume lowers the surface. `tolerance` is the permitted error, as a share of the
  // volume. If it is 5e-3 or more, the error may be a few percent larger: see
  // WriteBack::rough_volume. A collar rises by at most kMaxRise, and not beyond the lattice.
  // Nothing rises in the sweeps of `tools`. The volume has steps as a function of the rise. If the
  // wanted volume is inside a step, the collar uses the nearer side of the step. Errors: a
  // position, radius or volume is not finite; the radius is not above 0; the collar takes too much
  // memory.
  Result<Reshaped> raise(TriDexel& model, const Tool& tool, std::span<const PressingTool> tools,
                         size_t of, double radius_mm, double volume_mm3, double tolerance);

  // Returns the memory of the largest collar so far [bytes].
  size_t kept_bytes() const { return kBytesPerNode * band_.phi().capacity(); }

  // kRamp: distance from the sweep at which the collar has its full height [cells]. kMaxRise:
  // maximum rise of a collar [cells]. It is less than kRamp, so that nodes that rise do not pass
  // nodes that do not.
  static constexpr double kRamp = 4, kMaxRise = 3;
  // Memory of the bands and weights, for each node of a collar [bytes].
  static constexpr size_t kBytesPerNode = 40;

 private:
  void measure_path(const Tool& tool, std::span<const PressingTool> tools, double radius_mm,
                    const Lattice& lattice, const NodeBox& box);
  bool find_touched(const NodeBox& all, const LatticePoint& centre, double radius, float core);
  double weigh(const LatticePoint& centre, double radius);
  bool rise(const TriDexel& model, double wanted, double area, double max_rise, double tolerance);

  int threads_ = 1;
  NodeBand band_, path_band_;
  // A model on its own lattice that contains only the sweeps of the tools.
  std::unique_ptr<TriDexel> scratch_;
  Snapshot empty_;
  NodeValues after_;
  std::vector<NodeBlock> touched_;
  std::unique_ptr<WriteBack> writer_;
  std::vector<detail::FloatRow> weights_;  // one per touched block
  std::vector<double> areas_;              // weighted area of the surface in each block
};

}  // namespace kibori
