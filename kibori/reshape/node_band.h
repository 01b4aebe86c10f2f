// SPDX-License-Identifier: MIT
// Reads the signed distances phi of the lattice nodes near the surface. The ends of all three
// fields give one distance per node. Therefore, values that are computed from phi cannot differ
// between the fields.
//
//   inside     phi < 0; the z field decides
//   |phi|      the node x has a nearest end with the place p and the normal n; with d = x - p:
//              max(|d . n|, sqrt(max(0, |d|^2 - 1))), at most `width`
//
// The 1 in the formula is a sideways distance of one cell. Up to this distance, |phi| is the
// distance from the end's plane: the plane through the end, at right angles to its normal.
//
// A field sees a plane if one condition is true: along the field's rays, the component of the
// plane's normal is at least 0.75 of the largest component. Then the field has an end within 0.97
// cells of each point of the plane. Therefore, a node that has no end on its own lattice edges
// needs the ends of only one field. These ends are called `major`:
//
//   z   if the z field sees the plane
//   y   if the y field sees it, unless the component along z is above 0.87 of the largest
//   x   if the x field sees it, unless the component along z or y is above 0.87 of the largest
//
// There is a range of 4 degrees in which two fields have major ends. The other ends are called
// minor. A minor end serves only the two nodes of its lattice edge.
//
// The code processes nodes in rows along x. A row is divided into blocks of 16 nodes. If the rows
// run along the surface, only few rows are near it. Therefore, a band can be read with the model's
// axes renamed (the band's turn, an AxisTurn). Then boxes, nodes, places, normals, axes and fields
// all use the new names. The z field above is then the field whose new name is z.
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

// The nodes (i, j, k) with low <= (i, j, k) < high. The box may extend beyond the lattice. Nodes
// beyond the lattice are outside the material.
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

  // Returns a node's index in arrays with one element per node of the box. x varies fastest.
  size_t index(int i, int j, int k) const {
    return static_cast<size_t>(k - low[2]) * stride(2) +
           static_cast<size_t>(j - low[1]) * stride(1) + static_cast<size_t>(i - low[0]);
  }
  // Returns the difference of the indices of two neighbours along an axis (0, 1, 2: x, y, z).
  size_t stride(int axis) const {
    const auto nx = static_cast<size_t>(high[0] - low[0]);
    return axis == 0 ? 1 : axis == 1 ? nx : nx * static_cast<size_t>(high[1] - low[1]);
  }
  // Returns the node with the index `place`, which must be below 2^32.
  Index3 node_at(size_t place) const {
    const auto nx = static_cast<uint32_t>(high[0] - low[0]),
               ny = static_cast<uint32_t>(high[1] - low[1]);
    const uint32_t row = static_cast<uint32_t>(place) / nx;
    return {low[0] + static_cast<int>(static_cast<uint32_t>(place) % nx),
            low[1] + static_cast<int>(row % ny), low[2] + static_cast<int>(row / ny)};
  }
};

// Returns the box of all nodes of a lattice.
inline NodeBox lattice_nodes(const Lattice& lattice) { return {lattice.low(), lattice.high()}; }

// Some of the 16 nodes (i, j, k) ... (i + 15, j, k) of a box. If bit n of `nodes` is set, the node
// (i + n, j, k) is one of them.
struct NodeBlock {
  int i, j, k;
  // NodeBox::index of the node (i, j, k). If the block comes from NodeBand, its number is place /
  // 16.
  uint32_t place;
  uint16_t nodes;

  int first() const { return std::countr_zero(nodes); }
  int last() const { return 15 - std::countl_zero(nodes); }
  // Returns the bits of the nodes whose first coordinate c has low <= c < high.
  unsigned nodes_along(int low, int high) const {
    const int first = std::clamp(low - i, 0, 16), end = std::clamp(high - i, first, 16);
    return nodes & ((1u << end) - (1u << first));
  }
  // Calls f(n) for each node, where n is its bit.
  template <class F>
  void for_nodes(F&& f) const {
    for (unsigned bits = nodes; bits; bits &= bits - 1) f(std::countr_zero(bits));
  }
};

// A point where a ray enters or leaves the material.
struct SurfaceEnd {
  Eigen::Vector3f place;   // [lattice units]
  Eigen::Vector3f normal;  // unit, out of the material
  Axis axis : 8;           // axis of the ray
  uint8_t material;
  Color paint;
};
static_assert(sizeof(SurfaceEnd) == 32);  // half a cache line

struct BandSlice;

namespace detail {

// One value for each of 16 nodes along x (a block), or for each of the rays through them.
struct alignas(64) FloatRow {
  float lane[16];
};
struct alignas(64) IndexRow {
  int32_t lane[16];
};
// Returns the number of elements to allocate for `size` elements. The regions of one brush differ
// by up to one node per side. The extra room lets all of them use one allocation.
inline size_t with_room(size_t size) { return size + size / 8; }
// Allocates aligned memory, so that no row of 16 values crosses a cache line.
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
// Resizes `items` to `size` elements. Their values are unspecified.
template <class T, class A>
void make_items(std::vector<T, A>& items, size_t size) {
  if (size > items.capacity()) {
    items = {};
    items.reserve(with_room(size));
  }
  items.resize(size);
}
// Memory that the owner writes before it reads. Therefore, the memory is not cleared when it grows.
template <class T>
class Uncleared {
 public:
  // Makes room for `size` elements. Returns true if the memory is new.
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
// The items (spans, ends or layers) of one ray or block of rays: their range in a list.
struct RayItems {
  uint32_t first = 0, count = 0;
};
// For each of the 16 rays of a block: the depth and the index of one end. A negative index means
// that the ray has no end in this layer. BandSpans has one span of each ray.
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
// Working memory for the search of nearest ends in one slice of nodes. A seed is the nearest end on
// a node's own ray. A row value is the nearest end on all rays of a node's row.
struct BandScratch {
  // The squared distance of a node without an end. Row values get it before each slice, and seeds
  // before each field.
  float too_far = 0;
  Uncleared<FloatRow> seed_distance2, row_distance2;
  Uncleared<IndexRow> seed_end, row_end;
  // For each block:
  // - seeded: true if the block has seeds,
  // - seeds_near: true if there are seeds near the block along its row,
  // - rows_near: number of neighbouring rows whose nodes may have their nearest end in this block.
  std::vector<uint8_t> seeded, seeds_near, rows_near;
  size_t cols = 0, margin = 0;  // layout of the seeds: blocks per row, empty blocks around it
  bool prepared = false;        // true if prepare() has run for the current field

  void prepare(const BandSlice& slice);
  void clear_seeds();
};

// The nodes low <= i < high of a row along x. i counts from the start of the row.
struct RowRange {
  uint32_t low = UINT32_MAX, high = 0;

  void include(RowRange other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
};

}  // namespace detail

struct BandPlane;

// One value for each node of a box.
using NodeValues = std::vector<float, detail::RowAllocator<float>>;

// Selects the nodes of a box to read. Coordinates use the axis names after the band's turn.
struct BandPart {
  // Distances are read within a ball around `centre` with the radius `reach` [lattice units]. The
  // ball is extended by `around` along each axis. Some nodes next to the ball are read too.
  LatticePoint centre = {};
  float reach = kFar, around = 0;
  // A node's side is `inside` or `outside`. Sides are computed for nodes of the ball that are at
  // most `margin` nodes away along each axis from a node with a known distance. kAll: for all nodes
  // of the ball.
  static constexpr uint32_t kAll = UINT32_MAX;
  uint32_t margin = kAll;
};

// Returns the turn that makes rows along x follow the surface best. It considers the surface in the
// ball around `centre` with the radius `reach` [lattice units].
AxisTurn turn_along_surface(const TriDexel& model, const LatticePoint& centre, double reach);

// Reads and stores signed distances. Keeps its memory between calls. One thread may use it at a
// time.
class NodeBand {
 public:
  // Sets the number of threads of read(). It does not change the result.
  void set_threads(int threads) { threads_ = threads; }
  // Reads the nodes of `box` that `part` selects. phi of the other nodes is unspecified. `box` and
  // `part` use the axis names after `turn`. |phi| is at most `width` [lattice units], which must be
  // below 250. box() may be longer along x than `box`, because rows consist of whole blocks.
  void read(const TriDexel& model, const NodeBox& box, float width, AxisTurn turn = {},
            const BandPart& part = {});

  // Reads only the nodes `nodes` of `box`, which must be sorted by index. phi of the other nodes is
  // unspecified. The function uses only the nodes' indices, so `nodes` may come from another box of
  // the same size.
  void read_at(const TriDexel& model, const NodeBox& box, float width,
               const std::vector<NodeBlock>& nodes, AxisTurn turn = {});

  AxisTurn turn() const { return turn_; }
  const NodeBox& box() const { return box_; }
  float width() const { return width_; }
  size_t index(int i, int j, int k) const { return box_.index(i, j, k); }
  // Returns the number of blocks in a row. block() returns block number `at` of the row (j, k).
  size_t blocks_a_row() const { return blocks_; }
  NodeBlock block(size_t at, int j, int k) const {
    const int i = box_.low[0] + static_cast<int>(at * 16);
    const auto place = static_cast<uint32_t>(index(i, j, k));
    return {i, j, k, place, 0xffff};
  }
  size_t stride(int axis) const { return box_.stride(axis); }
  const NodeValues& phi() const { return phi_; }
  const std::vector<SurfaceEnd>& ends() const { return ends_; }
  // Returns the nodes with a known distance, sorted by index. A distance is known if the node has
  // an end within the width. Each node occurs once.
  const std::vector<NodeBlock>& blocks() const { return known_blocks_; }
  // Writes the nodes with a known distance and |phi| < depth to `to`, sorted by index.
  void blocks_within(float depth, std::vector<NodeBlock>& to) const;
  // Like above, but then calls keep(block) for each block. keep() may remove nodes from the block.
  // Several threads call keep() at the same time.
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
  // Returns the three fields, sorted by their number of major ends, largest first. This number
  // measures the area that the field sees best.
  std::array<Axis, 3> order_by_surface() const;
  // rows_of() writes for each row of the box the range that contains its nodes of `nodes`.
  // spread_rows() extends the ranges `from` to the rows within `reach` nodes along `axis`.
  void rows_of(const std::vector<NodeBlock>& nodes, std::vector<detail::RowRange>& to) const;
  void spread_rows(const std::vector<detail::RowRange>& from, int axis, uint32_t reach,
                   std::vector<detail::RowRange>& to) const;
  // Copies phi of `nodes`, and of all nodes up to two nodes away from them along each axis. The
  // indices in `to` are the same as in phi(). The function may copy more nodes.
  void copy_phi(const std::vector<NodeBlock>& nodes, NodeValues& to);
  // Copies phi of all nodes whose side was computed. Precondition: the last read() had a
  // BandPart::margin other than kAll.
  void copy_computed_phi(NodeValues& to) const { copy_rows(computed_, to); }
  // Returns the nearest end of node n of the block. Returns null if no end is within the width.
  const SurfaceEnd* nearest(const NodeBlock& block, int n) const {
    return nearest(block.place + static_cast<size_t>(n));
  }
  // Returns true if at least one end that was read has a mask.
  bool masked() const { return masked_; }
  // Returns the material of the nearest end of node n of the block, or nullopt without such an end.
  // If all ends have one material, the function does not read the end.
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
  // The major and the minor ends of one field. For y and z rays, `rays` has the layers of each
  // block of rays. For x rays, `rays` has the range of `ends` for each ray.
  struct FieldEnds {
    std::vector<SurfaceEnd> ends, minor;
    uint64_t materials = 0;  // one bit per material
    bool masked = false;     // true if at least one end has a mask
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
  size_t nx_ = 0, ny_ = 0, nz_ = 0, blocks_ = 0;  // blocks_: blocks per row
  int threads_ = 1;
  float width_ = 0, reach_ = 0, around_ = 0;
  Eigen::Vector3f centre_ = Eigen::Vector3f::Zero();
  float farthest_ = 0;  // maximum distance from a node to an end that it can use
  // As in BandSlice, for each axis: values for nodes and for ends. Along x, one value per block.
  std::array<std::vector<float>, 3> away_, ends_away_;
  NodeValues phi_;
  // For each block: squared distances and indices of the nearest ends so far. known_ has the bits
  // of the nodes that have a nearest end.
  detail::Uncleared<detail::FloatRow> distance2_;
  detail::Uncleared<detail::IndexRow> nearest_;
  std::vector<uint16_t> known_;
  std::vector<SurfaceEnd> ends_;
  size_t first_minor_ = 0;  // index of the first minor end in ends_
  std::optional<uint8_t> only_material_;
  bool masked_ = false;
  std::vector<NodeBlock> known_blocks_;
  std::array<FieldEnds, 3> fields_;  // join_ends() makes their indices refer to ends_
  // wanted_: the bits of the nodes to read in each block, unless all_wanted_ is true. depths_: for
  // each axis and each column of kColumn by kColumn rays, the depths of the ends that these nodes
  // may need.
  bool all_wanted_ = true;
  std::vector<uint16_t> wanted_;
  static constexpr int kColumn = 8;
  std::array<std::vector<detail::DepthRange>, 3> depths_;
  // The spans of the z field: the layers of each block of rays.
  std::vector<detail::RayItems> rays_;
  std::vector<detail::BandSpans> span_layers_;
  std::vector<detail::BandScratch> scratch_;  // one per thread
  std::array<std::vector<detail::RowRange>, 2> rows_;
  std::vector<detail::RowRange> computed_;
};

}  // namespace kibori
