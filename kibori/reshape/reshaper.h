// SPDX-License-Identifier: MIT
// Field operations: verbs that move the surface a little along its normal, dab by dab. A dab reads
// the signed distances of its region (node_band.h), changes them, and writes the change back
// (write_back.h); its cost is that of the region, whatever the model's size.
//
//   smooth     phi + s w (G phi - phi)       G: a Gaussian of the brush's sigma
//   rasp       max(phi, smooth)              takes from peaks only
//   fill       min(phi, smooth)              fills hollows only
//   inflate    phi - s w sigma               below 0: deflate
//   flatten    phi + s w (plane - phi)       plane: height over it, out of the material
//
// with the strength s and the falloff w of brush.h. A slab thinner than 1.6 sigma vanishes when it
// is smoothed at full strength.
//
// A dab may have images elsewhere. Where the regions of some meet, their falloffs add up to one
// dab: to 1 at most, and where they inflate to kMaxSum.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <kibori/reshape/brush.h>
#include <kibori/reshape/node_band.h>

namespace kibori {

// Where a dab lies. `plane`: of flatten; without one, the brush's own, or the plane fitted to the
// surface within the brush.
struct DabPlace {
  Vec3 centre_mm = Vec3::Zero();
  std::optional<FlatPlane> plane = {};
};

class WriteBack;

// Computes dabs, and keeps its memory from one to the next. For one thread at a time.
class Reshaper {
 public:
  Reshaper();
  ~Reshaper();
  // On how many threads a dab runs; results do not depend on it.
  void set_threads(int threads) {
    threads_ = threads;
    band_.set_threads(threads);
  }
  // One dab on the model, at the place of the hand and those of its images. Nothing where the brush
  // meets no surface. `owed_mm3`: what a dab that keeps volume is to add, as those before it did
  // not; it gives back as much of that as raises the surface by 0.02 cells. Errors: a brush that
  // check_brush refuses, a place or plane that is not finite, a region of more than 2^31 nodes or
  // than there is memory for.
  Result<Reshaped> dab(TriDexel& model, FieldVerb verb, const Brush& brush,
                       std::span<const DabPlace> places, double owed_mm3 = 0);
  Result<Reshaped> dab(TriDexel& model, FieldVerb verb, const Brush& brush, const Vec3& centre_mm,
                       const std::optional<FlatPlane>& plane = {}) {
    const DabPlace place{centre_mm, plane};
    return dab(model, verb, brush, std::span(&place, 1));
  }

  // The surface within the brush, weighted by the falloff.
  struct Surface {
    FlatPlane plane;       // through its centre of area, with its mean normal
    uint8_t material = 0;  // the most common one
  };
  // Nothing where there is no surface, or where its normals cancel out.
  std::optional<Surface> surface_under(const TriDexel& model, const Brush& brush,
                                       const Vec3& centre_mm);

  // Of the largest region yet [bytes].
  size_t kept_bytes() const { return kBytesPerNode * band_.phi().capacity(); }

  static constexpr double kMaxSum = 4;
  // What band and filter keep of a region's node.
  static constexpr size_t kBytesPerNode = 24;

 private:
  // A place within reach of the lattice, in its units.
  struct Centre {
    LatticePoint at;
    FlatPlane flat;  // of flatten, point in lattice units
  };
  // Places whose regions meet.
  struct Cluster {
    NodeBox region;
    std::vector<Centre> centres;
    bool own = false;  // the hand's place is one of them
    double owed = 0;   // [lattice units^3]

    // A place, and how far the centres are from it.
    std::pair<LatticePoint, double> middle() const;
    Cluster turned(AxisTurn by) const;
  };
  Result<Reshaped> dab_cluster(TriDexel& model, FieldVerb verb, const Brush& brush, double radius,
                               double sigma, double width, const Cluster& cluster);
  bool tell_after(const TriDexel& model, FieldVerb verb, const Brush& brush, double radius,
                  double sigma, const Cluster& cluster, std::optional<float> core, double most);
  void weigh(const Brush& brush, const Cluster& cluster, double radius, double most,
             std::optional<float> core);
  // Calls f(index, weight) for the nodes that a verb may change, or for those of one block.
  template <class F>
  void for_touched(F&& f) const {
    for (size_t b = 0; b < touched_.size(); b++) for_touched(b, f);
  }
  template <class F>
  void for_touched(size_t b, F&& f) const {
    touched_[b].for_nodes([&](int n) {
      f(touched_[b].place + static_cast<size_t>(n), weights_[b][static_cast<size_t>(n)]);
    });
  }
  void filter();
  void sum_along(int axis, const NodeValues& from, NodeValues& to,
                 const std::vector<detail::RowRange>& rows);

  int threads_ = 1;
  NodeBand band_;
  std::vector<float> kernel_;
  NodeValues after_, first_, second_;
  // Nodes that a verb may change, and of each block's nodes the falloff, and for flatten the height
  // over the plane.
  using BlockValues = std::array<float, 16>;
  std::vector<NodeBlock> touched_;
  std::unique_ptr<WriteBack> writer_;
  std::vector<BlockValues> weights_, heights_;
  std::array<std::vector<detail::RowRange>, 3> rows_;  // by passes of the filter
};

}  // namespace kibori
