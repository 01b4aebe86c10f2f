// SPDX-License-Identifier: MIT
// Signed distances at the lattice nodes near the surface, from the ends of all three fields at
// once: so that what is computed from them cannot differ by field.
//
//   inside     phi < 0, decided by the z field
//   |phi|      from the node's nearest end (place p, normal n), at a distance d = x - p:
//              max(|d . n|, sqrt(max(0, |d|^2 - 1))), at most `width`
//
// The 1 is one cell of sideways distance: within it an end's own plane is trusted. A field has an
// end so near to each point of a plane (within 0.97 cells) if the normal's component along its rays
// is 0.75 of the largest or more. So one field's ends do for farther nodes: the `major` ones,
//
//   z   wherever that holds
//   y   where it holds, unless the component along z is above 0.87 of the largest
//   x   where it holds, unless that along z or y is
//
// which leaves 4 degrees in which one field takes over from another. Others are for the two nodes
// of their lattice edge alone.
//
// Nodes are gone over in rows along x. Those are fewest near a surface that they run along; so a
// band may be read with the model's axes turned. Boxes, nodes, places, normals and axes are then
// all by the new names, and of the fields, too: the z field above is the one of that name.
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

// Nodes low <= (i, j, k) < high. May reach beyond the lattice: there every node is outside.
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

// Some of the 16 nodes (i, j, k) ... (i + 15, j, k) of a box: bit n of `nodes` stands for i + n.
struct NodeBlock {
  int i, j, k;
  uint32_t place;  // of the first node, as of NodeBox::index; of the box's blocks: place / 16
  uint16_t nodes;

  int first() const { return std::countr_zero(nodes); }
  int last() const { return 15 - std::countl_zero(nodes); }
  // Those with low <= i < high.
  unsigned nodes_along(int low, int high) const {
    const int first = std::clamp(low - i, 0, 16), end = std::clamp(high - i, first, 16);
    return nodes & ((1u << end) - (1u << first));
  }
  // Calls f(n) for each.
  template <class F>
  void for_nodes(F&& f) const {
    for (unsigned bits = nodes; bits; bits &= bits - 1) f(std::countr_zero(bits));
  }
};

// Where a ray enters or leaves the material.
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

// 16 nodes beside each other along x, or the rays through them: a block.
struct alignas(64) FloatRow {
  float lane[16];
};
struct alignas(64) IndexRow {
  int32_t lane[16];
};
// Regions of one brush differ by a node a side: memory for one does for the others, too.
inline size_t with_room(size_t size) { return size + size / 8; }
// Memory that begins where a row of 16 may: so that no such row lies across two cache lines.
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
// Makes `size` items, whose values mean nothing.
template <class T, class A>
void make_items(std::vector<T, A>& items, size_t size) {
  if (size > items.capacity()) {
    items = {};
    items.reserve(with_room(size));
  }
  items.resize(size);
}
// Memory that is written before it is read, so that it is not cleared when it grows.
template <class T>
class Uncleared {
 public:
  // Whether the memory is new.
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
// What rays have of something, as indices.
struct RayItems {
  uint32_t first = 0, count = 0;
};
// Of each of a block's rays one end (below 0: none), or one span.
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
// Of one slice of nodes while nearest ends are looked for.
struct BandScratch {
  // What has no end is this far off. Between slices all rows are, between fields all seeds, too.
  float too_far = 0;
  Uncleared<FloatRow> seed_distance2, row_distance2;
  Uncleared<IndexRow> seed_end, row_end;
  // Of each block: whether it has seeds; whether there are some near along the row; of how many
  // rows from here on an end of this one may be nearest.
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

// A value of each node of a box.
using NodeValues = std::vector<float, detail::RowAllocator<float>>;

// Which nodes of a box are read, by the names that the band's turn gives.
struct BandPart {
  // Distances: of those within the ball of radius `reach` round `centre` [lattice units], grown by
  // `around` along each axis, and of some beside them.
  LatticePoint centre = {};
  float reach = kFar, around = 0;
  // Sides: of those within so many nodes, along each axis, of a known distance, as far as the ball
  // goes.
  static constexpr uint32_t kAll = UINT32_MAX;
  uint32_t beside = kAll;
};

// The turn after which rows along x run along the surface within a ball, as nearly as they can.
AxisTurn turn_along_surface(const TriDexel& model, const LatticePoint& centre, double reach);

// Memory is kept from one use to the next.
class NodeBand {
 public:
  // On how many threads read() runs; the result does not depend on it.
  void set_threads(int threads) { threads_ = threads; }
  // Reads a part of the nodes of `box`, by the names that `turn` gives; phi of the others means
  // nothing. `width` [lattice units]: distances beyond it are not told apart. The band's box is
  // this one, but longer along x if need be: its rows are whole blocks.
  void read(const TriDexel& model, const NodeBox& box, float width, AxisTurn turn = {},
            const BandPart& part = {});

  // Reads some nodes of `box`, in the order of their indices; phi of the others means nothing. Only
  // their places in the box are looked at: they may be another's, of a box as large.
  void read_at(const TriDexel& model, const NodeBox& box, float width,
               const std::vector<NodeBlock>& nodes, AxisTurn turn = {});

  AxisTurn turn() const { return turn_; }
  const NodeBox& box() const { return box_; }
  float width() const { return width_; }
  size_t index(int i, int j, int k) const { return box_.index(i, j, k); }
  // The `at`-th 16 nodes of a row.
  size_t blocks_a_row() const { return blocks_; }
  NodeBlock block(size_t at, int j, int k) const {
    const int i = box_.low[0] + static_cast<int>(at * 16);
    const auto place = static_cast<uint32_t>(index(i, j, k));
    return {i, j, k, place, 0xffff};
  }
  size_t stride(int axis) const { return box_.stride(axis); }
  const NodeValues& phi() const { return phi_; }
  const std::vector<SurfaceEnd>& ends() const { return ends_; }
  // Nodes whose phi is known better than its sign, each once, in the order of their indices.
  const std::vector<NodeBlock>& blocks() const { return known_blocks_; }
  // Those of them with |phi| < depth, in the same order.
  void blocks_within(float depth, std::vector<NodeBlock>& to) const;
  // Of those what keep(block) leaves of their nodes; on all threads.
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
  // Fields in the order of how much of the surface they see best, that one first.
  std::array<Axis, 3> order_by_surface() const;
  // Ranges of the box's rows that hold the nodes, and ranges that hold what lies within `reach`
  // nodes of others, along one axis.
  void rows_of(const std::vector<NodeBlock>& nodes, std::vector<detail::RowRange>& to) const;
  void spread_rows(const std::vector<detail::RowRange>& from, int axis, uint32_t reach,
                   std::vector<detail::RowRange>& to) const;
  // Copies phi of the nodes, of those within two nodes of them along each axis, and of some beside
  // those, to the same places of `to`.
  void copy_phi(const std::vector<NodeBlock>& nodes, NodeValues& to);
  // The same of all nodes whose sides were told, where those are not all: see BandPart::beside.
  void copy_told_phi(NodeValues& to) const { copy_rows(told_, to); }
  // A node's nearest end of those that may be its, or null if there is none within the width.
  const SurfaceEnd* nearest(const NodeBlock& block, int n) const {
    return nearest(block.place + static_cast<size_t>(n));
  }
  // That end's material; without a look at it where all are of one.
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
  // Of one field: major ends, of blocks of rays in layers, of x rays by each; and the other ends.
  struct FieldEnds {
    std::vector<SurfaceEnd> ends, minor;
    uint64_t materials = 0;  // bits
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
  void list_known(uint32_t beside);
  void tell_sides(uint32_t beside);
  void copy_rows(const std::vector<detail::RowRange>& rows, NodeValues& to) const;
  // See BandKernels.
  static auto nodes_within_depth() -> uint32_t (*)(const float* phi, float depth);
  BandPlane plane(size_t k);

  AxisTurn turn_;
  NodeBox box_;
  size_t nx_ = 0, ny_ = 0, nz_ = 0, blocks_ = 0;  // blocks: rows of 16 nodes along x
  int threads_ = 1;
  float width_ = 0, reach_ = 0, around_ = 0;
  Eigen::Vector3f centre_ = Eigen::Vector3f::Zero();
  float farthest_ = 0;  // an end that is told from none, of a node
  // By axis: squared distances of nodes, along x of blocks, from the ball; and of their ends.
  std::array<std::vector<float>, 3> away_, ends_away_;
  NodeValues phi_;
  // By blocks: squared distance and index of the nearest end yet, and for which nodes there is one.
  detail::Uncleared<detail::FloatRow> distance2_;
  detail::Uncleared<detail::IndexRow> nearest_;
  std::vector<uint16_t> known_;
  std::vector<SurfaceEnd> ends_;
  size_t first_minor_ = 0;  // of ends_
  std::optional<uint8_t> only_material_;
  std::vector<NodeBlock> known_blocks_;
  std::array<FieldEnds, 3> fields_;  // once joined, by indices of ends_
  // Where only some nodes are wanted: those of each block; and by axis, for columns of kColumn by
  // kColumn rays, at which depths ends may be nearest to one of them.
  bool all_wanted_ = true;
  std::vector<uint16_t> wanted_;
  static constexpr int kColumn = 8;
  std::array<std::vector<detail::DepthRange>, 3> depths_;
  // Spans of blocks of z rays.
  std::vector<detail::RayItems> rays_;
  std::vector<detail::BandSpans> span_layers_;
  std::vector<detail::BandScratch> scratch_;  // of each thread
  std::array<std::vector<detail::RowRange>, 2> rows_;
  std::vector<detail::RowRange> told_;
};

}  // namespace kibori
