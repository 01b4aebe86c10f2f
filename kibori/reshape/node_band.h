// SPDX-License-Identifier: MIT
// Signed distances at the lattice nodes near the surface, from the ends of all three fields at
// once: so that what is computed from them cannot differ by field.
//
//   inside     phi < 0, decided by the z field
//   |phi|      from the node's nearest end (place p, normal n), at a distance d = x - p:
//              max(|d . n|, sqrt(max(0, |d|^2 - 1))), at most `width`
//
// The 1 is one cell of sideways distance: within it an end's own plane is trusted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// Nodes low <= (i, j, k) < high. May reach beyond the lattice: there every node is outside.
struct NodeBox {
  Index3 low = Index3::Zero(), high = Index3::Zero();

  bool empty() const { return (high <= low).any(); }
  Index3 size() const { return high - low; }
  NodeBox grown(int by) const { return {low - by, high + by}; }
  NodeBox within(const NodeBox& other) const { return {low.max(other.low), high.min(other.high)}; }
  bool holds(const NodeBox& other) const {
    return (other.low >= low).all() && (other.high <= high).all();
  }

  // Of arrays with a place for each node, x fastest.
  size_t index(int i, int j, int k) const {
    return static_cast<size_t>(k - low[2]) * stride(2) +
           static_cast<size_t>(j - low[1]) * stride(1) + static_cast<size_t>(i - low[0]);
  }
  // Steps of an index along x, y and z.
  size_t stride(int axis) const {
    const auto nx = static_cast<size_t>(high[0] - low[0]);
    return axis == 0 ? 1 : axis == 1 ? nx : nx * static_cast<size_t>(high[1] - low[1]);
  }
  // `place`: an index below 2^32.
  Index3 node_at(size_t place) const {
    const auto nx = static_cast<uint32_t>(high[0] - low[0]),
               ny = static_cast<uint32_t>(high[1] - low[1]);
    const uint32_t row = static_cast<uint32_t>(place) / nx;
    return {low[0] + static_cast<int>(static_cast<uint32_t>(place) % nx),
            low[1] + static_cast<int>(row % ny), low[2] + static_cast<int>(row / ny)};
  }
};

// Where a ray enters or leaves the material.
struct SurfaceEnd {
  Eigen::Vector3f place;   // [lattice units]
  Eigen::Vector3f normal;  // unit, out of the material
  Axis axis;               // of the ray
  uint8_t material;
  Color paint;
};

// Memory is kept from one use to the next.
class NodeBand {
 public:
  // Reads the nodes of `box`. `width` [lattice units]: distances beyond it are not told apart, nor
  // those of the box's outermost layer, nor farther than `reach` from `centre`.
  void read(const TriDexel& model, const NodeBox& box, float width, const LatticePoint& centre = {},
            float reach = kFar);

  const NodeBox& box() const { return box_; }
  float width() const { return width_; }
  size_t index(int i, int j, int k) const { return box_.index(i, j, k); }
  size_t stride(int axis) const { return box_.stride(axis); }
  const std::vector<float>& phi() const { return phi_; }
  const std::vector<SurfaceEnd>& ends() const { return ends_; }
  // Nodes whose phi is known better than its sign, each once.
  const std::vector<uint32_t>& nodes() const { return nodes_; }
  Index3 node_at(size_t index) const { return box_.node_at(index); }
  // A node's nearest end, or null if there is none within the width.
  const SurfaceEnd* nearest(size_t node) const {
    return nearest_[node] < 0 ? nullptr : &ends_[static_cast<size_t>(nearest_[node])];
  }

 private:
  struct Place {
    float x, y, z;
  };
  // A node whose nearest end is known, or is to be found next.
  struct WaveNode {
    uint32_t index;
    Place at;
  };
  void read_inside(const TriDexel& model);
  void read_ends(const TriDexel& model, Axis axis);
  void seed(const Index3& node, int32_t end);
  void spread(const Eigen::Vector3f& centre, float reach);
  // Takes the end if it is nearer.
  void offer(const WaveNode& node, int32_t end) {
    const Place& place = places_[static_cast<size_t>(end)];
    const float dx = node.at.x - place.x, dy = node.at.y - place.y, dz = node.at.z - place.z;
    const float distance2 = dx * dx + dy * dy + dz * dz;
    if (nearest_[node.index] >= 0 && !(distance2 < distance2_[node.index])) return;
    distance2_[node.index] = distance2;
    nearest_[node.index] = end;
  }

  NodeBox box_;
  Index3 size_ = Index3::Zero();
  float width_ = 0;
  std::vector<float> phi_, distance2_;  // the latter known where `nearest_` is
  std::vector<int32_t> nearest_;        // below 0: none
  std::vector<SurfaceEnd> ends_;
  std::vector<Place> places_;  // of the ends, once more and close together
  std::vector<uint32_t> nodes_;
  std::vector<WaveNode> wave_, next_wave_;
};

}  // namespace kibori
