// SPDX-License-Identifier: MIT
// Field operations: verbs that move the surface a little along its normal, dab by dab. A dab reads
// the signed distances of its region (node_band.h), changes them, and writes the change back
// (write_back.h). Its cost is that of the region, for any size of the model.
//
//   smooth     phi + s w (G phi - phi)       G: a Gaussian of the brush's sigma
//   rasp       max(phi, smooth)              removes peaks only
//   fill       min(phi, smooth)              fills hollows only
//   inflate    phi - s w sigma               below 0: deflate
//   flatten    phi + s w (plane - phi)       plane: height over it, out of the material
//   trim       max(phi, flatten)             removes what is above the plane only
//   build      min(phi, flatten)             adds up to the plane, raised by sigma
//
// Here s is the strength and w the falloff of brush.h. Smoothing at full strength removes a slab
// thinner than 1.6 sigma.
//
// The mask of the surface (color.h) reduces w: each node has the mask of its nearest end.
//
// A dab may have images elsewhere. If their regions meet, their falloffs add up in one dab: to at
// most 1, or kMaxSum for inflate.
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

class WriteBack;

// Computes dabs, and keeps its memory between them. For one thread at a time.
class Reshaper {
 public:
  Reshaper();
  ~Reshaper();
  // Number of threads of a dab. It does not change the result.
  void set_threads(int threads) {
    threads_ = threads;
    band_.set_threads(threads);
  }
  // One dab on the model, at the hand's place and those of its images. Does nothing if the brush
  // meets no surface. `pending_mm3` is volume that earlier dabs with `keep_volume` did not restore.
  // The dab restores at most the volume that raises the surface by 0.02 cells. Errors: a brush that
  // check_brush rejects, a place or plane that is not finite, a region of more than 2^31 nodes, or
  // too little memory.
  Result<Reshaped> dab(TriDexel& model, FieldVerb verb, const Brush& brush,
                       std::span<const DabPlace> places, double pending_mm3 = 0);
  Result<Reshaped> dab(TriDexel& model, FieldVerb verb, const Brush& brush, const Vec3& centre_mm,
                       const std::optional<FlatPlane>& plane = {}) {
    const DabPlace place{centre_mm, plane};
    return dab(model, verb, brush, std::span(&place, 1));
  }

  // The surface within the brush, weighted by the falloff.
  struct SurfaceSample {
    FlatPlane plane;       // through its centre of area, with its mean normal
    uint8_t material = 0;  // the most common one
  };
  // nullopt if there is no surface, or if its normals cancel out.
  std::optional<SurfaceSample> surface_under(const TriDexel& model, const Brush& brush,
                                             const Vec3& centre_mm);

  // Memory of the largest region so far [bytes].
  size_t kept_bytes() const { return kBytesPerNode * band_.phi().capacity(); }

  static constexpr double kMaxSum = 4;
  // Memory of band and filter per node of a region [bytes].
  static constexpr size_t kBytesPerNode = 24;

 private:
  // A place within reach of the lattice, in lattice units.
  struct Centre {
    LatticePoint at;
    FlatPlane flat;  // for verbs that work towards a plane, point in lattice units
    AlphaFrame alpha;
  };
  // Places whose regions meet.
  struct Cluster {
    NodeBox region;
    std::vector<Centre> centres;
    bool own = false;    // true if the hand's place is one of them
    double pending = 0;  // [lattice units^3]

    // A middle point, and the largest distance of the centres from it.
    std::pair<LatticePoint, double> middle() const;
    Cluster turned(AxisTurn by) const;
  };
  Result<Reshaped> dab_cluster(TriDexel& model, FieldVerb verb, const Brush& brush, double radius,
                               double sigma, double width, const Cluster& cluster);
  bool compute_phi_after(const TriDexel& model, FieldVerb verb, const Brush& brush, double radius,
                         double sigma, const Cluster& cluster, std::optional<float> core,
                         double max_sum);
  void weigh(const Brush& brush, const Cluster& cluster, double radius, double max_sum,
             std::optional<float> core);
  void mask_weights(FieldVerb verb);
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
  bool clipped_ = false;  // compute_phi_after dropped material beyond the lattice
  NodeBand band_;
  std::vector<float> kernel_;
  NodeValues after_, first_, second_;
  // The nodes that a verb may change. Per block, the falloff at each node, and the height over
  // the plane for verbs that work towards one.
  using BlockValues = std::array<float, 16>;
  std::vector<NodeBlock> touched_;
  std::unique_ptr<WriteBack> writer_;
  std::vector<BlockValues> weights_, heights_;
  std::array<std::vector<detail::RowRange>, 3> rows_;  // per pass of the filter
};

}  // namespace kibori
