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
//   w = falloff(|x - c| / R) * clamp(distance to the way / kRamp, 0, 1)
//
// with the one lambda that adds the wanted volume, the mean of the three fields: measured by their
// spans, or, where a share of it may be missed, told from distances at nodes. The
// way is the tool, swept forward and back by R along its motion and out along its axis: there
// nothing rises, so that a furrow stays open behind the tool, no wave is driven before it, and
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

// A tool that presses: where it stands, the direction of its motion (unit, or 0 where it only
// turns), and the middle of what it took last.
struct PressingTool {
  Pose pose;
  Vec3 direction = Vec3::Zero();
  Vec3 middle_mm = Vec3::Zero();
};

class WriteBack;

// Raises collars, and keeps its memory from one to the next. For one thread at a time.
class Clay {
 public:
  Clay();
  ~Clay();
  // On how many threads a collar is raised; results do not depend on it.
  void set_threads(int threads) {
    threads_ = threads;
    band_.set_threads(threads);
    way_band_.set_threads(threads);
  }
  // The surface within `radius_mm` of the middle of `tools[of]` rises until `volume_mm3` was added,
  // give or take a share `tolerance` of it (from 5e-3 on, some percent more: see
  // WriteBack::rough_volume), or as far as one collar goes: kMaxRise at its highest,
  // and no farther than the lattice. Below 0 it sinks. Nothing rises in the way of any of the
  // tools. Where a step of the volume lies around the wanted one, the nearer side is taken. Errors:
  // a place, radius or volume that is not finite, a region that there is no memory for.
  Result<Reshaped> raise(TriDexel& model, const Tool& tool, std::span<const PressingTool> tools,
                         size_t of, double radius_mm, double volume_mm3, double tolerance);

  // Of the largest collar yet [bytes].
  size_t kept_bytes() const { return kBytesPerNode * band_.phi().capacity(); }

  // Distance from the way [cells] at which the collar has its whole height, and the most that one
  // collar rises [cells]: less than kRamp, so that what rises does not pass what stays.
  static constexpr double kRamp = 4, kMaxRise = 3;
  // What bands and weights keep of a collar's node.
  static constexpr size_t kBytesPerNode = 40;

 private:
  void measure_way(const Tool& tool, std::span<const PressingTool> tools, double radius_mm,
                   const Lattice& lattice, const NodeBox& box);
  bool find_touched(const Index3& nodes, const LatticePoint& centre, double radius, float core);
  double weigh(const LatticePoint& centre, double radius);
  bool rise(const TriDexel& model, double wanted, double area, double most, double tolerance);

  int threads_ = 1;
  NodeBand band_, way_band_;
  // The tools' ways alone, on a lattice of their own.
  std::unique_ptr<TriDexel> scratch_;
  Snapshot empty_;
  NodeValues after_;
  std::vector<NodeBlock> touched_;
  std::unique_ptr<WriteBack> writer_;
  std::vector<detail::FloatRow> weights_;  // of each block's nodes
  std::vector<double> areas_;              // of each block's surface, weighed
};

}  // namespace kibori
