// SPDX-License-Identifier: MIT
// Field operations: dabs (single changes) that move the surface a little along its normal. A dab
// reads the signed distances phi of its region (node_band.h), changes them, and writes the change
// back (write_back.h). The time of a dab depends on the size of the region, not of the model.
//
//   smooth     phi + s w (G phi - phi)       G: Gaussian filter with the brush's sigma
//   rasp       max(phi, smooth)              removes peaks only
//   fill       min(phi, smooth)              fills hollows only
//   inflate    phi - s w sigma               with s below 0: deflate
//   flatten    phi + s w (plane - phi)       plane: height above the plane, along its normal
//   trim       max(phi, flatten)             removes only what is above the plane
//   build      min(phi, flatten)             adds material up to the plane, raised by sigma
//
// Here s is the brush's strength and w its falloff (brush.h). Smoothing at full strength removes
// slabs that are thinner than 1.6 sigma.
//
// The mask of the surface (color.h) reduces w. A node has the mask of its nearest end.
//
// A dab may have images at other places. If the regions of images meet, they become one dab with
// the sum of the falloffs. The sum is limited to 1, or to kMaxSum for inflate.
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

// Computes dabs, and keeps its memory between them. One thread may use it at a time.
class Reshaper {
 public:
  Reshaper();
  ~Reshaper();
  // Sets the number of threads of a dab. It does not change the result.
  void set_threads(int threads) {
    threads_ = threads;
    band_.set_threads(threads);
  }
  // Makes one dab at each place: the hand's place first, then its images. Does nothing where the
  // brush meets no surface. `pending_mm3` is the volume that earlier dabs with `keep_volume` did
  // not restore. The dab restores at most the part of it that raises the surface by 0.02 cells.
  // Errors: check_brush rejects the brush; a place or plane is not finite; a region has more than
  // 2^31 nodes or takes too much memory.
  Result<Reshaped> dab(TriDexel& model, FieldVerb verb, const Brush& brush,
                       std::span<const DabPlace> places, double pending_mm3 = 0);
  Result<Reshaped> dab(TriDexel& model, FieldVerb verb, const Brush& brush, const Vec3& centre_mm,
                       const std::optional<FlatPlane>& plane = {}) {
    const DabPlace place{centre_mm, plane};
    return dab(model, verb, brush, std::span(&place, 1));
  }

  // The surface within the brush. The falloff weights the means.
  struct SurfaceSample {
    FlatPlane plane;       // through the centre of the area, with the mean normal
    uint8_t material = 0;  // the most common one
  };
  // Returns nullopt if the brush meets no surface, if the normals cancel out, or if check_brush
  // rejects the brush.
  std::optional<SurfaceSample> surface_under(const TriDexel& model, const Brush& brush,
                                             const Vec3& centre_mm);

  // Returns the memory of the largest region so far [bytes].
  size_t kept_bytes() const { return kBytesPerNode * band_.phi().capacity(); }

  static constexpr double kMaxSum = 4;
  // Memory of the band and of the filter, for each node of a region [bytes].
  static constexpr size_t kBytesPerNode = 24;

 private:
  // A place whose ball meets the lattice, in lattice units.
  struct Centre {
    LatticePoint at;
    FlatPlane flat;  // plane of verbs that need one; its point is in lattice units
    AlphaFrame alpha;
  };
  // Places whose regions meet. They are processed as one dab.
  struct Cluster {
    NodeBox region;
    std::vector<Centre> centres;
    bool own = false;    // true if the hand's place is one of them
    double pending = 0;  // [lattice units^3]

    // Returns a middle point, and the largest distance of a centre from it.
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
  // Calls f(index, weight) for all nodes that the verb may change, or for those of block `b`.
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
  // The nodes that the verb may change. weights_ has the falloff at each node of each block.
  // heights_ has the heights above the plane, for verbs that need one.
  using BlockValues = std::array<float, 16>;
  std::vector<NodeBlock> touched_;
  std::unique_ptr<WriteBack> writer_;
  std::vector<BlockValues> weights_, heights_;
  std::array<std::vector<detail::RowRange>, 3> rows_;  // one for each pass of the filter
};

}  // namespace kibori
