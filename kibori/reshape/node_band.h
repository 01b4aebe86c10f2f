// SPDX-License-Identifier: MIT
// Signed distances at the lattice nodes near the surface, from the ends of all three fields
// together. Therefore, values that are computed from them cannot differ by field.
//
//   inside     phi < 0, decided by the z field
//   |phi|      from the node's nearest end (place p, normal n), at a distance d = x - p:
//              max(|d . n|, sqrt(max(0, |d|^2 - 1))), at most `width`
//
// The 1 is a sideways distance of one cell. Up to that distance, |phi| is the distance from the
// end's plane. A field sees a plane if the component of the plane's normal along the field's rays
// is at least 0.75 of the largest component. It then has an end within 0.97 cells of each point of
// the plane. Therefore, nodes that are no neighbours of the surface need the ends of only one
// field. These are the `major` ends:
//
//   z   if the z field sees the plane
//   y   if the y field sees it, unless the component along z is above 0.87 of the largest
//   x   if the x field sees it, unless the component along z or y is above 0.87 of the largest
//
// So there is a range of 4 degrees in which two fields have major ends. Each of the other ends
// serves only the two nodes of its lattice edge.
//
// Nodes are processed in rows along x. The fewest rows are near a surface if the rows run along it.
// Therefore, a band can be read with the model's axes renamed (AxisTurn). Then boxes, nodes,
// places, normals, axes and fields all use the new names. The z field above is the field with the
// new name z.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <optional>
#include <vector>

#include <kibori/base/parallel.h>
#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// Nodes low <= (i, j, k) < high. The box may extend beyond the lattice; nodes there are outside.
struct NodeBox {
  Index3 low = Index3::Zero(), high = Index3::Zero();

  NodeBox turned(AxisTurn by) const { return {by.turn(low), by.turn(high)}; }

  bool empty() const { return (high <= low).any(); }
  Index3 size() const { return high - low; }
  NodeBox grown(int by) const { return {low - by, high + by}; }
  NodeBox within(const NodeBox& other) const { return {low.max(other.low), high.min(other.high)}; }
  bool holds(const NodeBox& other) const {
    return (other.low >= low).all() && (other.high <= high).all();
  }

  // Index into arrays with one element per node, x fastest.
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

// The nodes of a lattice.
inline NodeBox lattice_nodes(const Lattice& lattice) { return {lattice.low(), lattice.high()}; }

// A subset of the 16 nodes (i, j, k) ... (i + 15, j, k) of a box. Bit n of `nodes` is node i + n.
struct NodeBlock {
  int i, j, k;
  // NodeBox::index of the first node; for the box's own blocks, the block number is place / 16
  uint32_t place;
  uint16_t nodes;

  int first() const { return std::countr_zero(nodes); }
  int last() const { return 15 - std::countl_zero(nodes); }
  // The nodes with low <= i < high.
  unsigned nodes_along(int low, int high) const {
    const int first = std::clamp(low - i, 0, 16), end = std::clamp(high - i, first, 16);
    return nodes & ((1u << end) - (1u << first));
  }
  // Calls f(n) for each node.
  template <class F>
  void for_nodes(F&& f) const {
    for (unsigned bits = nodes; bits; bits &= bits - 1) f(std::countr_zero(bits));
  }
};

// A point where a ray enters or leaves the material.
struct SurfaceEnd {
  Eigen::Vector3f place;   // [lattice units]
  Eigen::Vector3f normal;  // unit, out of the material
  Axis axis : 8;           // of the ray
  uint8_t material;
  Color paint;
};
static_assert(sizeof(SurfaceEnd) == 32);  // half a cache line

struct BandSlice;

namespace detail {

// A block: 16 consecutive nodes along x, or the rays through them.
struct alignas(64) FloatRow {
  float lane[16];
};
struct alignas(64) IndexRow {
  int32_t lane[16];
};
// Regions of one brush differ by up to a node per side. The extra memory lets them share one
// allocation.
inline size_t with_room(size_t size) { return size + size / 8; }
// Aligned memory, so that no row of 16 crosses a cache line.
template <class T>
struct RowAllocator {
  using value_type = T;

  RowAllocator() = default;
  template <class U>
  RowAllocator(const RowAllocator<U>&) {}
  T* allocate(size_t count) {
    return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{alignof(FloatRow)}));
  }
  void deallocate(T* items, size_t) {
    ::operator delete (items, std::align_val_t{alignof(FloatRow)});
  }
  bool operator==(const RowAllocator&) const = default;
};
// Makes `size` items with unspecified values.
template <class T, class A>
void make_items(std::vector<T, A>& items, size_t size) {
  if (size > items.capacity()) {
    items = {};
    items.reserve(with_room(size));
  }
  items.resize(size);
}
// Memory that is written before it is read, so it is not cleared when it grows.
template <class T>
class Uncleared {
 public:
  // Returns true if the memory is new.
  bool resize(size_t size) {
    if (size <= size_) return false;
    items_.reset();
    size_ = with_room(size);
    items_ = std::make_unique_for_overwrite<T[]>(size_);
    return true;
  }
  size_t size() const { return size_; }
  T* data() { return items_.get(); }
  T& operator[](size_t i) { return items_[i]; }
  const T& operator[](size_t i) const { return items_[i]; }

 private:
  std::unique_ptr<T[]> items_;
  size_t size_ = 0;
};
// The items of a ray, as a range of indices.
struct RayItems {
  uint32_t first = 0, count = 0;
};
// For each ray of a block: one end (negative: none), or one span.
struct EndLayer {
  FloatRow depth;
  IndexRow end;
};
struct BandSpans {
  FloatRow in, out;
};
struct DepthRange {
  float low = kFar, high = -kFar;

  void include(float depth) {
    low = std::min(low, depth);
    high = std::max(high, depth);
  }
};
// Memory of one slice of nodes during the search for nearest ends.
struct BandScratch {
  // The squared distance of a node without an end. It is the initial value of rows before each
  // slice, and of seeds before each field.
  float too_far = 0;
  Uncleared<FloatRow> seed_distance2, row_distance2;
  Uncleared<IndexRow> seed_end, row_end;
  // Per block:
  // - it has seeds,
  // - there are seeds near it along the row,
  // - number of adjacent rows with nodes whose nearest end may be in this row.
  std::vector<uint8_t> seeded, seeds_near, rows_near;
  size_t cols = 0, margin = 0;  // of the seeds
  bool prepared = false;        // for the field

  void prepare(const BandSlice& slice);
  void clear_seeds();
};

// Nodes low <= i < high of a row along x.
struct RowRange {
  uint32_t low = UINT32_MAX, high = 0;

  void include(RowRange other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
};

}  // namespace detail

struct BandPlane;

// One value per node of a box.
using NodeValues = std::vector<float, detail::RowAllocator<float>>;

// The nodes of a box that are read, with the names after the band's turn.
struct BandPart {
  // Distances are read within a ball of radius `reach` around `centre` [lattice units]. The ball is
  // grown by `around` along each axis. Some nodes next to it are read too.
  LatticePoint centre = {};
  float reach = kFar, around = 0;
  // Sides (inside or outside) are computed for nodes in the ball near a node with a known distance:
  // at most this number of nodes away along each axis.
  static constexpr uint32_t kAll = UINT32_MAX;
  uint32_t margin = kAll;
};

// The turn of the axes after which rows along x follow the surface in a ball most closely.
AxisTurn turn_along_surface(const TriDexel& model, const LatticePoint& centre, double reach);

// Reads and stores signed distances. Keeps its memory between uses.
class NodeBand {
 public:
  // Number of threads of read(). It does not change the result.
  void set_threads(int threads) { threads_ = threads; }
  // Reads a part of the nodes of `box`, with the names after `turn`. phi of the other nodes is
  // unspecified. Distances beyond `width` [lattice units] are not resolved. The band's box may be
  // longer along x, because its rows are whole blocks.
  void read(const TriDexel& model, const NodeBox& box, float width, AxisTurn turn = {},
            const BandPart& part = {});

  // Reads some nodes of `box`. `nodes` is in the order of their indices. phi of the other nodes is
  // unspecified. The function uses only the nodes' indices in the box, so `nodes` may come from
  // another box of the same size.
  void read_at(const TriDexel& model, const NodeBox& box, float width,
               const std::vector<NodeBlock>& nodes, AxisTurn turn = {});

  AxisTurn turn() const { return turn_; }
  const NodeBox& box() const { return box_; }
  float width() const { return width_; }
  size_t index(int i, int j, int k) const { return box_.index(i, j, k); }
  // Number of blocks of 16 nodes in a row. block() returns the `at`-th one.
  size_t blocks_a_row() const { return blocks_; }
  NodeBlock block(size_t at, int j, int k) const {
    const int i = box_.low[0] + static_cast<int>(at * 16);
    const auto place = static_cast<uint32_t>(index(i, j, k));
    return {i, j, k, place, 0xffff};
  }
  size_t stride(int axis) const { return box_.stride(axis); }
  const NodeValues& phi() const { return phi_; }
  const std::vector<SurfaceEnd>& ends() const { return ends_; }
  // Nodes with a known distance, each once, in the order of their indices.
  const std::vector<NodeBlock>& blocks() const { return known_blocks_; }
  // The subset with |phi| < depth, in the same order.
  void blocks_within(float depth, std::vector<NodeBlock>& to) const;
  // The same subset after keep(block) has removed nodes from each block. Runs on all threads.
  template <class Keep>
  void blocks_within(float depth, std::vector<NodeBlock>& to, Keep&& keep) const {
    detail::make_items(to, known_blocks_.size());
    const auto within = nodes_within_depth();
    run_parallel_pieces(threads_, to.size(), [&](size_t b) {
      NodeBlock& block = to[b] = known_blocks_[b];
      block.nodes &= static_cast<uint16_t>(within(phi_.data() + block.place, depth));
      if (block.nodes) keep(block);
    });
    std::erase_if(to, [](const NodeBlock& block) { return block.nodes == 0; });
  }
  Index3 node_at(size_t index) const { return box_.node_at(index); }
  // The three fields, ordered by the share of the surface that each measures best, largest first.
  std::array<Axis, 3> order_by_surface() const;
  // rows_of returns the range of each row that contains the nodes. spread_rows extends ranges to
  // the rows within `reach` nodes along one axis.
  void rows_of(const std::vector<NodeBlock>& nodes, std::vector<detail::RowRange>& to) const;
  void spread_rows(const std::vector<detail::RowRange>& from, int axis, uint32_t reach,
                   std::vector<detail::RowRange>& to) const;
  // Copies phi of these nodes to the same indices of `to`, and of all nodes up to two nodes away
  // along each axis. It may copy some more.
  void copy_phi(const std::vector<NodeBlock>& nodes, NodeValues& to);
  // The same for all nodes with a computed side. Call it only after a read() with a
  // BandPart::margin.
  void copy_computed_phi(NodeValues& to) const { copy_rows(computed_, to); }
  // A node's nearest end; null if there is none within the width.
  const SurfaceEnd* nearest(const NodeBlock& block, int n) const {
    return nearest(block.place + static_cast<size_t>(n));
  }
  // True if some end has a mask.
  bool masked() const { return masked_; }
  // That end's material. It does not read the end if all ends have one material.
  std::optional<uint8_t> material(const NodeBlock& block, int n) const {
    const SurfaceEnd* end = nearest(block, n);
    if (!end) return std::nullopt;
    return only_material_ ? only_material_ : end->material;
  }
  const SurfaceEnd* nearest(size_t node) const {
    if (!(known_[node / 16] >> node % 16 & 1)) return nullptr;
    return &ends_[static_cast<size_t>(nearest_[node / 16].lane[node % 16])];
  }

 private:
  void read_wanted(const TriDexel& model, const NodeBox& box, float width, const BandPart& part,
                   const std::vector<NodeBlock>* wanted);
  void read_spans(const TriDexel& model);
  // For one field: its major ends and its other ends. The major ends are in layers for blocks of
  // rays; those of the x field are in lists for single rays.
  struct FieldEnds {
    std::vector<SurfaceEnd> ends, minor;
    uint64_t materials = 0;  // bits
    bool masked = false;     // one of them has a mask
    std::vector<detail::RayItems> rays;
    std::vector<detail::EndLayer> layers;
    std::vector<detail::DepthRange> of_rows, of_rays;
  };
  template <Axis axis>
  void read_ends(const TriDexel& model);
  template <Axis axis, class F>
  void add_ends(const FieldSnapshot& field, int u, int v, FieldEnds& to, F&& f) const;
  void want(const std::vector<NodeBlock>& nodes);
  detail::DepthRange wanted_depths(Axis axis, int u, int v) const;
  void join_ends();
  void search(Axis axis);
  void offer_minor_ends();
  void list_known(uint32_t margin);
  void compute_sides(uint32_t margin);
  void copy_rows(const std::vector<detail::RowRange>& rows, NodeValues& to) const;
  // See BandKernels.
  static auto nodes_within_depth() -> uint32_t (*)(const float* phi, float depth);
  BandPlane plane(size_t k);

  AxisTurn turn_;
  NodeBox box_;
  size_t nx_ = 0, ny_ = 0, nz_ = 0, blocks_ = 0;  // blocks_: blocks of 16 nodes per row
  int threads_ = 1;
  float width_ = 0, reach_ = 0, around_ = 0;
  Eigen::Vector3f centre_ = Eigen::Vector3f::Zero();
  float farthest_ = 0;  // maximum useful distance of an end from a node
  // As in BandSlice, by axis: of nodes (along x: of blocks), and of their ends.
  std::array<std::vector<float>, 3> away_, ends_away_;
  NodeValues phi_;
  // Per block: squared distance and index of the nearest end so far, and the nodes that have one.
  detail::Uncleared<detail::FloatRow> distance2_;
  detail::Uncleared<detail::IndexRow> nearest_;
  std::vector<uint16_t> known_;
  std::vector<SurfaceEnd> ends_;
  size_t first_minor_ = 0;  // in ends_
  std::optional<uint8_t> only_material_;
  bool masked_ = false;
  std::vector<NodeBlock> known_blocks_;
  std::array<FieldEnds, 3> fields_;  // after the join, as indices into ends_
  // If only some nodes are wanted: the nodes of each block. By axis, for columns of kColumn by
  // kColumn rays: the depths at which ends may be nearest to one of them.
  bool all_wanted_ = true;
  std::vector<uint16_t> wanted_;
  static constexpr int kColumn = 8;
  std::array<std::vector<detail::DepthRange>, 3> depths_;
  // Spans of the z field, by blocks of rays.
  std::vector<detail::RayItems> rays_;
  std::vector<detail::BandSpans> span_layers_;
  std::vector<detail::BandScratch> scratch_;  // per thread
  std::array<std::vector<detail::RowRange>, 2> rows_;
  std::vector<detail::RowRange> computed_;
};

}  // namespace kibori
