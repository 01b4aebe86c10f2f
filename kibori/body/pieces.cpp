// SPDX-License-Identifier: MIT
#include <kibori/body/pieces.h>

#include <algorithm>
#include <array>
#include <bit>
#include <climits>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include <kibori/base/parallel.h>
#include <kibori/edit/ray_edit.h>

namespace kibori {
namespace {

// Nodes k of a ray with begin <= k < end are inside a span.
struct NodeRange {
  int begin, end;
  bool empty() const { return begin >= end; }
  bool shares(const NodeRange& other) const {
    return std::max(begin, other.begin) < std::min(end, other.end);
  }
};

// std::ceil for values in the range of int. Written so that a compiler can vectorise it.
int ceil_of(float x) {
  const int down = static_cast<int>(x);
  return down + (static_cast<float>(down) < x);
}

NodeRange nodes_of(float in, float out) { return {ceil_of(in - 0.5f), ceil_of(out - 0.5f)}; }

// Lanes u0 to u1 of rows v0 to v1 of a tile, all included.
struct RayBlock {
  int u0 = 0, v0 = 0, u1 = kTileSide - 1, v1 = kTileSide - 1;
  bool is_tile() const { return u0 == 0 && v0 == 0 && u1 == kTileSide - 1 && v1 == kTileSide - 1; }
};

// A plane with at least one node index that all its spans contain. So the spans are connected, and
// belong to one piece.
struct WholePlane {
  NodeRange all, any;  // nodes that every span contains; first to last node of any span
  bool continues;  // the spans begin where those of the previous plane end, so the piece continues
};

// A tile whose rays with material form a rectangular block, and whose planes are all whole. Most
// tiles are like this, except at the rims of a body.
struct WholeTile {
  RayBlock block;
  std::vector<WholePlane> planes;  // planes that have spans; empty: the tile is not whole
};

struct Extremes {
  float min = kFar, max = -kFar;
  void add(float x) {
    min = x < min ? x : min;
    max = x > max ? x : max;
  }
};

// Minimum and maximum of value(slot) over a block of rays.
template <class F>
Extremes extremes(const RayBlock& block, F&& value) {
  Extremes all;
  if (block.is_tile()) {  // lane by lane, so that the compiler vectorises it
    std::array<float, kTileSide> min, max;
    min.fill(kFar);
    max.fill(-kFar);
    for (size_t row = 0; row < kTileRays; row += kTileSide)
      for (size_t lane = 0; lane < kTileSide; lane++) {
        const float x = value(row + lane);
        min[lane] = x < min[lane] ? x : min[lane];
        max[lane] = x > max[lane] ? x : max[lane];
      }
    for (const float x : min) all.add(x);
    for (const float x : max) all.add(x);
  } else {
    for (int v = block.v0; v <= block.v1; v++)
      for (int u = block.u0; u <= block.u1; u++)
        all.add(value(static_cast<size_t>(v * kTileSide + u)));
  }
  return all;
}

// The block of a plane's rays that have a span; nullopt if they form no block.
std::optional<RayBlock> block_of(const Plane& plane) {
  std::array<unsigned, kTileSide> lanes{};
  RayBlock block;
  block.v0 = kTileSide;
  for (size_t row = 0; row < kTileSide; row++) {
    for (size_t lane = 0; lane < kTileSide; lane++) {
      const size_t slot = row * kTileSide + lane;
      lanes[row] |= static_cast<unsigned>(plane.in[slot] < plane.out[slot]) << lane;
    }
    if (!lanes[row]) continue;
    block.v0 = std::min(block.v0, static_cast<int>(row));
    block.v1 = static_cast<int>(row);
  }
  if (block.v0 == kTileSide) return {};
  const unsigned one = lanes[static_cast<size_t>(block.v0)];
  block.u0 = std::countr_zero(one);
  block.u1 = std::bit_width(one) - 1;
  if (std::popcount(one) != block.u1 - block.u0 + 1) return {};
  for (int v = block.v0; v <= block.v1; v++)
    if (lanes[static_cast<size_t>(v)] != one) return {};
  return block;
}

// Spans that are farther apart than this [cells] have a node between them.
constexpr float kApart = 1.01f;

// Prefetches the ends of a plane's spans, while the caller works on the plane before it.
void fetch(const Plane& plane) {
  for (size_t slot = 0; slot < kTileRays; slot += 64 / sizeof(float)) {
    __builtin_prefetch(plane.in + slot);
    __builtin_prefetch(plane.out + slot);
  }
  __builtin_prefetch(&plane.next);
}

// Returns no planes if one of them is not whole. Also if some rays have a node between a plane and
// the plane before, and others may have none: then the two planes may be one piece or two.
WholeTile whole_tile(const Tile& tile) {
  WholeTile whole;
  const Plane* before = nullptr;
  for (const Plane* p = &tile.first; p; before = std::exchange(p, p->next)) {
    if (p->next) fetch(*p->next);
    const auto in = [&](size_t slot) { return p->in[slot]; };
    const auto out = [&](size_t slot) { return p->out[slot]; };
    Extremes ins = extremes(whole.block, in);
    if (ins.min == kFar) break;  // it has no span
    if (ins.max == kFar) {       // a ray is empty
      const std::optional<RayBlock> block = before ? std::nullopt : block_of(*p);
      if (!block) return {};
      whole.block = *block;
      ins = extremes(whole.block, in);
    }
    const Extremes outs = extremes(whole.block, out);
    Extremes gap;
    if (before)
      gap = extremes(whole.block, [&](size_t slot) { return p->in[slot] - before->out[slot]; });
    const bool continues = before && gap.max == 0;
    const WholePlane plane{nodes_of(ins.max, outs.min), nodes_of(ins.min, outs.max), continues};
    if (plane.all.empty() || (before && !continues && gap.min < kApart)) return {};
    whole.planes.push_back(plane);
  }
  return whole;
}

// Walks along the spans of a ray.
class RayWalk {
 public:
  RayWalk(const Tile& tile, size_t slot) : plane_(&tile.first), slot_(slot) {}
  bool at_end() const { return !plane_ || plane_->empty_at(static_cast<int>(slot_)); }
  NodeRange nodes() const { return nodes_of(plane_->in[slot_], plane_->out[slot_]); }
  int number() const { return number_; }
  size_t slot() const { return slot_; }
  void next() {
    plane_ = plane_->next;
    number_++;
  }

 private:
  const Plane* plane_;
  size_t slot_;
  int number_ = 0;
};

// Calls f(span index of one, span index of the other) for spans that share a node.
template <class F>
void for_shared(RayWalk one, RayWalk other, F&& f) {
  while (!one.at_end() && !other.at_end()) {
    const NodeRange a = one.nodes(), b = other.nodes();
    if (a.shares(b)) f(one.number(), other.number());
    if (a.end < b.end)
      one.next();
    else
      other.next();
  }
}

// True if some ray has spans in both planes that share a node. It checks all rays at once.
bool share_a_node(const Plane& one, const Plane& other) {
  constexpr float kBeyond = 1e6f;  // beyond every lattice; an empty slot ends before it begins
  int sharing = 0;
  for (size_t slot = 0; slot < kTileRays; slot++) {
    const float in = one.in[slot] > other.in[slot] ? one.in[slot] : other.in[slot],
                out = one.out[slot] < other.out[slot] ? one.out[slot] : other.out[slot];
    const float from = in < kBeyond ? in : kBeyond, to = out > -kBeyond ? out : -kBeyond;
    sharing |= ceil_of(from - 0.5f) < ceil_of(to - 0.5f);
  }
  return sharing != 0;
}

int planes_of(const Tile& tile) {
  int count = 0;
  for (const Plane* p = &tile.first; p; p = p->next) count++;
  return count;
}

size_t size_of(int index) { return static_cast<size_t>(index); }

}  // namespace

// Finds pieces. While it works, a label is the number of a part. Parts that touch are united. At
// the end, labels become numbers of pieces.
class PieceFinder {
 public:
  // `mask` selects tiles of the z field; null selects all.
  PieceFinder(const FieldSnapshot& z, const std::vector<bool>* mask) : z_(z), mask_(mask) {
    found_.tu_begin_ = z.tu_begin();
    found_.tv_begin_ = z.tv_begin();
    found_.tiles_u_ = z.tu_end() - z.tu_begin();
    found_.tiles_.resize(index(z.tu_end() - 1, z.tv_end() - 1) + 1);
    whole_.resize(found_.tiles_.size());
    for (int tv = z.tv_begin(); tv < z.tv_end(); tv++)
      for (int tu = z.tu_begin(); tu < z.tu_end(); tu++) {
        if (!looks_at(tu, tv)) continue;
        if (tu + 1 < z.tu_end() && looks_at(tu + 1, tv)) fetch(z.tile(tu + 1, tv).first);
        read_tile(tu, tv);
        if (tu > z.tu_begin() && looks_at(tu - 1, tv)) join(tu - 1, tv, tu, tv);
        if (tv > z.tv_begin() && looks_at(tu, tv - 1)) join(tu, tv - 1, tu, tv);
      }
  }

  Pieces take() {
    std::vector<int> number(parent_.size(), -1);
    for (size_t part = 0; part < parent_.size(); part++) {
      const auto root = size_of(root_of(static_cast<int>(part)));
      if (number[root] < 0) {
        number[root] = static_cast<int>(found_.pieces_.size());
        found_.pieces_.emplace_back();
      }
      number[part] = number[root];
      Piece& piece = found_.pieces_[size_of(number[root])];
      piece.nodes += parts_[part].nodes;
      piece.box.include(parts_[part].box);
    }
    for (int& label : found_.labels_)
      if (label >= 0) label = number[size_of(label)];
    return std::move(found_);
  }

 private:
  size_t index(int tu, int tv) const { return found_.tile_at(tu, tv); }
  bool looks_at(int tu, int tv) const {
    return !z_.tile(tu, tv).empty && (!mask_ || (*mask_)[index(tu, tv)]);
  }

  int new_part() {
    parent_.push_back(static_cast<int>(parent_.size()));
    parts_.emplace_back();
    return parent_.back();
  }
  int root_of(int part) {
    while (parent_[size_of(part)] != part) {
      int& up = parent_[size_of(part)];
      up = parent_[size_of(up)];
      part = up;
    }
    return part;
  }
  // The lower number stays, so that the result does not depend on the order.
  void unite(int a, int b) {
    a = root_of(a);
    b = root_of(b);
    if (a == b) return;
    parent_[size_of(std::max(a, b))] = std::min(a, b);
  }
  void count(int part, int u, int v, NodeRange nodes) {
    Piece& p = parts_[size_of(part)];
    p.nodes += nodes.end - nodes.begin;
    NodeBounds box;
    box.min = Index3(u, v, nodes.begin);
    box.max = Index3(u, v, nodes.end - 1);
    p.box.include(box);
  }

  // If every plane is whole, each plane gets one part in one step.
  bool read_whole(const Tile& tile, int tu, int tv) {
    const WholeTile& whole = whole_[index(tu, tv)] = whole_tile(tile);
    if (whole.planes.empty()) return false;
    const RayBlock& block = whole.block;
    found_.tiles_[index(tu, tv)] = {static_cast<int64_t>(found_.labels_.size()), true};
    const Plane* plane = &tile.first;
    for (const WholePlane& of : whole.planes) {
      const int part = of.continues ? found_.labels_.back() : new_part();
      found_.labels_.push_back(part);
      Piece& p = parts_[size_of(part)];
      for (int v = block.v0; v <= block.v1; v++) {
        int nodes = 0;
        for (int slot = v * kTileSide + block.u0; slot <= v * kTileSide + block.u1; slot++)
          nodes += ceil_of(plane->out[slot] - 0.5f) - ceil_of(plane->in[slot] - 0.5f);
        p.nodes += nodes;
      }
      NodeBounds box;
      box.min = Index3(tu * kTileSide + block.u0, tv * kTileSide + block.v0, of.any.begin);
      box.max = Index3(tu * kTileSide + block.u1, tv * kTileSide + block.v1, of.any.end - 1);
      p.box.include(box);
      plane = plane->next;
    }
    return true;
  }

  void read_tile(int tu, int tv) {
    const Tile& tile = z_.tile(tu, tv);
    if (read_whole(tile, tu, tv)) return;
    Pieces::TileLabels& labels = found_.tiles_[index(tu, tv)];
    labels.first = static_cast<int64_t>(found_.labels_.size());
    found_.labels_.resize(found_.labels_.size() + size_of(planes_of(tile)) * kTileRays, -1);
    for (size_t slot = 0; slot < kTileRays; slot++) {
      int before = -1, before_end = INT_MIN;
      for (RayWalk walk(tile, slot); !walk.at_end(); walk.next()) {
        const NodeRange nodes = walk.nodes();
        if (nodes.empty()) continue;
        // If only the material changes along a ray, the part continues.
        const int part = before_end == nodes.begin ? before : new_part();
        label(labels, walk.number(), slot) = part;
        count(part, tu * kTileSide + static_cast<int>(slot % kTileSide),
              tv * kTileSide + static_cast<int>(slot / kTileSide), nodes);
        before = part;
        before_end = nodes.end;
      }
      const auto join_slots = [&](size_t other) {
        for_shared(RayWalk(tile, other), RayWalk(tile, slot),
                   [&](int a, int b) { unite(label(labels, a, other), label(labels, b, slot)); });
      };
      if (slot % kTileSide > 0) join_slots(slot - 1);
      if (slot >= kTileSide) join_slots(slot - kTileSide);
    }
  }

  int& label(const Pieces::TileLabels& labels, int number, size_t slot) {
    return found_.labels_[labels.index(number, slot)];
  }

  // Joins the rays on both sides of the border between two tiles. The second tile is farther along
  // u or v.
  void join(int tu0, int tv0, int tu1, int tv1) {
    const size_t one = index(tu0, tv0), other = index(tu1, tv1);
    if (join_whole(one, other, tu0 != tu1)) return;
    const Pieces::TileLabels &a = found_.tiles_[one], &b = found_.tiles_[other];
    const Tile &before = z_.tile(tu0, tv0), &after = z_.tile(tu1, tv1);
    for (size_t i = 0; i < kTileSide; i++) {
      const size_t slot_a =
          tu0 != tu1 ? i * kTileSide + kTileSide - 1 : (kTileSide - 1) * kTileSide + i;
      const size_t slot_b = tu0 != tu1 ? i * kTileSide : i;
      for_shared(RayWalk(before, slot_a), RayWalk(after, slot_b),
                 [&](int p, int q) { unite(label(a, p, slot_a), label(b, q, slot_b)); });
    }
  }
  // Joins two tiles by their whole planes. Returns true if no ray needs a check. `along_u`: the
  // second tile is next to the first along u, otherwise along v.
  bool join_whole(size_t one, size_t other, bool along_u) {
    const WholeTile &a = whole_[one], &b = whole_[other];
    if (a.planes.empty() || b.planes.empty()) return false;
    const RayBlock &p = a.block, &q = b.block;
    const bool meet = along_u ? p.u1 == kTileSide - 1 && q.u0 == 0 && p.v0 <= q.v1 && q.v0 <= p.v1
                              : p.v1 == kTileSide - 1 && q.v0 == 0 && p.u0 <= q.u1 && q.u0 <= p.u1;
    if (!meet) return true;
    bool known = true;
    for (size_t i = 0; i < a.planes.size(); i++)
      for (size_t j = 0; j < b.planes.size(); j++) {
        if (a.planes[i].all.shares(b.planes[j].all))
          unite(found_.labels_[found_.tiles_[one].index(static_cast<int>(i), 0)],
                found_.labels_[found_.tiles_[other].index(static_cast<int>(j), 0)]);
        else if (a.planes[i].any.shares(b.planes[j].any))
          known = false;
      }
    return known;
  }

  const FieldSnapshot& z_;
  const std::vector<bool>* mask_;
  Pieces found_;
  std::vector<WholeTile> whole_;  // per tile
  std::vector<int> parent_;
  std::vector<Piece> parts_;
};

int Pieces::of_span(int u, int v, int span) const {
  const TileLabels& tile = tiles_[tile_at(tile_of_node(u), tile_of_node(v))];
  if (tile.first < 0) return -1;
  return labels_[tile.index(span, size_of(slot_of_ray(u, v)))];
}

int Pieces::at(const FieldSnapshot& z, const Index3& node) const {
  if (!z.has_ray(node[0], node[1])) return -1;
  const Tile& tile = z.tile(tile_of_node(node[0]), tile_of_node(node[1]));
  const auto slot = size_of(slot_of_ray(node[0], node[1]));
  for (RayWalk walk(tile, slot); !walk.at_end(); walk.next()) {
    const NodeRange nodes = walk.nodes();
    if (node[2] < nodes.begin) return -1;
    if (node[2] < nodes.end) return of_span(node[0], node[1], walk.number());
  }
  return -1;
}

Pieces find_pieces(const Snapshot& model) {
  return PieceFinder(model.field(Axis::z), nullptr).take();
}

namespace {

// One field of a model, while pieces move from it to the portions' fields.
class FieldParter {
 public:
  // fields[0] belongs to the model, which keeps what moves to no other. fields[k] belongs to
  // portion k - 1.
  FieldParter(std::vector<Field*> fields, const Snapshot& before, const Pieces& pieces,
              const std::vector<int>& to)
      : axis_(fields.front()->axis()),
        fields_(std::move(fields)),
        was_(before.field(axis_)),
        z_(before.field(Axis::z)),
        pieces_(pieces),
        to_(to),
        near_(fields_.size() + 1) {}

  void run() {
    for (int tv = was_.tv_begin(); tv < was_.tv_end(); tv++)
      for (int tu = was_.tu_begin(); tu < was_.tu_end(); tu++) {
        if (tu + 1 < was_.tu_end()) fetch(was_.tile(tu + 1, tv).first);
        if (!was_.tile(tu, tv).empty) part_tile(was_.tile(tu, tv), tu, tv);
      }
  }

 private:
  // The index of a piece's field; fields_.size() if the piece is dropped.
  size_t field_of(int piece) const {
    const int to = to_[size_of(piece)];
    return to == kGone ? fields_.size() : size_of(to + 1);
  }

  void part_tile(const Tile& tile, int tu, int tv) {
    // Depths are not compared: a span may reach half a cell beyond its nodes, or past a node
    // because of rounding.
    const int u = tu * kTileSide, v = tv * kTileSide;
    std::fill(near_.begin(), near_.end(), false);
    bool all_stays = true;
    for (size_t piece = 0; piece < to_.size(); piece++) {
      if (to_[piece] == kStays) continue;
      if (!pieces_.all()[piece].box.meets(axis_, u, v, u + kTileSide - 1, v + kTileSide - 1))
        continue;
      near_[field_of(static_cast<int>(piece))] = true;
      all_stays = false;
    }
    for (size_t k = 1; k < fields_.size(); k++)
      if (!near_[k]) fields_[k]->clear_tile(tu, tv);
    near_[0] = true;
    if (!all_stays && !by_planes(tile, tu, tv)) by_spans(tile, tu, tv);
  }

  int piece_at(int u, int v, int depth) const {
    Index3 node;
    node[u_index(axis_)] = u;
    node[v_index(axis_)] = v;
    node[depth_index(axis_)] = depth;
    return pieces_.at(z_, node);
  }

  // The piece of each plane of a tile, if each plane is one piece; otherwise empty.
  std::vector<int> pieces_of_planes(const Tile& tile, int tu, int tv) const {
    const int u = tu * kTileSide, v = tv * kTileSide;
    std::vector<int> pieces;
    if (axis_ == Axis::z) {
      if (!pieces_.by_plane(tu, tv)) return {};
      size_t slot = 0;
      while (tile.first.empty_at(static_cast<int>(slot))) slot++;
      for (RayWalk walk(tile, slot); !walk.at_end(); walk.next())
        pieces.push_back(pieces_.of_span(u, v, walk.number()));
    } else {
      const WholeTile whole = whole_tile(tile);
      for (const WholePlane& plane : whole.planes) {
        pieces.push_back(piece_at(u + whole.block.u0, v + whole.block.v0, plane.all.begin));
        if (pieces.back() < 0) return {};
      }
    }
    return pieces;
  }

  // Moves whole planes if each plane is one piece. Returns true if so.
  bool by_planes(const Tile& tile, int tu, int tv) {
    const std::vector<int> pieces = pieces_of_planes(tile, tu, tv);
    if (pieces.empty()) return false;
    std::vector<bool> stays(pieces.size());
    for (size_t k = 0; k < fields_.size(); k++) {
      if (!near_[k]) continue;
      for (size_t i = 0; i < pieces.size(); i++) stays[i] = field_of(pieces[i]) == k;
      if (std::find(stays.begin(), stays.end(), false) != stays.end())
        fields_[k]->keep_planes(tu, tv, stays);
    }
    return true;
  }

  void by_spans(const Tile& tile, int tu, int tv) {
    // Plane by plane, in the order of memory.
    field_of_span_.clear();
    size_t spans = 0;
    int number = 0;
    for (const Plane* p = &tile.first; p; p = p->next, number++) {
      const size_t first = field_of_span_.size();
      field_of_span_.resize(first + kTileRays, kNoSpan);
      std::array<NodeRange, kTileRays> nodes;
      std::array<int, kTileRays> pieces;
      for (size_t slot = 0; slot < kTileRays; slot++) {
        pieces[slot] = -1;
        nodes[slot] = {0, 0};
        if (p->empty_at(static_cast<int>(slot))) continue;
        const int u = tu * kTileSide + static_cast<int>(slot) % kTileSide,
                  v = tv * kTileSide + static_cast<int>(slot) / kTileSide;
        int& piece = pieces[slot];
        if (axis_ == Axis::z) {
          piece = pieces_.of_span(u, v, number);
        } else {
          nodes[slot] = nodes_of(p->in[slot], p->out[slot]);
          // If the span and its neighbour contain a node at the same depth, both belong to the same
          // piece.
          if (slot > 0) {
            const size_t neighbour = slot % kTileSide > 0 ? slot - 1 : slot - kTileSide;
            if (nodes[slot].shares(nodes[neighbour])) piece = pieces[neighbour];
          }
          for (int k = nodes[slot].begin; k < nodes[slot].end && piece < 0; k++)
            piece = piece_at(u, v, k);
        }
        // A span that contains no node stays.
        field_of_span_[first + slot] = piece < 0 ? 0 : field_of(piece);
        spans++;
      }
    }
    for (size_t k = 0; k < fields_.size(); k++) {
      if (!near_[k]) continue;
      const auto stay =
          static_cast<size_t>(std::count(field_of_span_.begin(), field_of_span_.end(), k));
      if (stay == 0) fields_[k]->clear_tile(tu, tv);
      if (stay == 0 || stay == spans) continue;
      Tile& writable = fields_[k]->writable(tu, tv);
      for (size_t slot = 0; slot < kTileRays; slot++) {
        keep_.clear();
        for (size_t i = slot; i < field_of_span_.size() && field_of_span_[i] != kNoSpan;
             i += kTileRays)
          keep_.push_back(field_of_span_[i] == k);
        if (std::find(keep_.begin(), keep_.end(), false) != keep_.end())
          keep_spans(*fields_[k], writable, static_cast<int>(slot), keep_);
      }
      fields_[k]->trim_planes(writable);
    }
  }

  const Axis axis_;
  const std::vector<Field*> fields_;
  const FieldSnapshot &was_, &z_;
  const Pieces& pieces_;
  const std::vector<int>& to_;
  std::vector<bool> near_;  // per field: a piece that goes there may meet the tile
  // field_of_span_: index into fields_, by plane and slot. keep_: for each span of one ray, true if
  // it stays. Both are scratch memory.
  static constexpr size_t kNoSpan = SIZE_MAX;
  std::vector<size_t> field_of_span_;
  std::vector<bool> keep_;
};

}  // namespace

std::vector<Snapshot> part_pieces(TriDexel& model, const Pieces& pieces, const std::vector<int>& to,
                                  int threads) {
  const Snapshot before = model.snapshot();
  const int last =
      std::accumulate(to.begin(), to.end(), kStays, [](int a, int b) { return std::max(a, b); });
  std::vector<TriDexel> portions;
  for (int k = 0; k <= last; k++) portions.emplace_back(before, model.material_bounds());
  run_parallel(threads, kAxes.size(), [&](size_t i) {
    std::vector<Field*> fields{&model.field(kAxes[i])};
    for (TriDexel& portion : portions) fields.push_back(&portion.field(kAxes[i]));
    FieldParter(std::move(fields), before, pieces, to).run();
  });
  model.touch();
  std::vector<Snapshot> made;
  made.reserve(portions.size());
  for (const TriDexel& portion : portions) made.push_back(portion.snapshot());
  return made;
}

namespace {

// Tiles of a z field to check: as a mask by index, and as a list of (tu, tv).
struct TilePlaces {
  std::vector<bool> mask;
  std::vector<std::pair<int, int>> list;
};

// The changed tiles and their neighbours, so that every node next to a removed one is checked too.
TilePlaces changed_places(const FieldSnapshot& was, const FieldSnapshot& is) {
  const int tiles_u = is.tu_end() - is.tu_begin();
  const auto index = [&](int tu, int tv) {
    return size_of((tv - is.tv_begin()) * tiles_u + tu - is.tu_begin());
  };
  TilePlaces places;
  places.mask.assign(index(is.tu_end() - 1, is.tv_end() - 1) + 1, false);
  is.for_changed_tiles(was, [&](int tu, int tv, const Tile&, const Tile&) {
    for (const auto& [du, dv] : {std::pair{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const int u = tu + du, v = tv + dv;
      if (!is.has_tile(u, v) || places.mask[index(u, v)]) continue;
      places.mask[index(u, v)] = true;
      places.list.emplace_back(u, v);
    }
  });
  return places;
}

size_t tiles_with_material(const FieldSnapshot& z) {
  size_t count = 0;
  for (int tv = z.tv_begin(); tv < z.tv_end(); tv++)
    for (int tu = z.tu_begin(); tu < z.tu_end(); tu++) count += !z.tile(tu, tv).empty;
  return count;
}

// Per piece of `before`: the pieces of `after` that contain nodes of it.
using Fates = std::vector<std::vector<int>>;

// Looks only at the nodes in these tiles.
Fates find_fates(const FieldSnapshot& was, const Pieces& old_pieces, const FieldSnapshot& is,
                 const Pieces& new_pieces, const TilePlaces& places) {
  Fates fates(old_pieces.all().size());
  const auto overlaps = [&](int old_piece, int new_piece) {
    std::vector<int>& pieces = fates[size_of(old_piece)];
    if (std::find(pieces.begin(), pieces.end(), new_piece) == pieces.end())
      pieces.push_back(new_piece);
  };
  for (const auto& [tu, tv] : places.list) {
    const Tile &old_tile = was.tile(tu, tv), &new_tile = is.tile(tu, tv);
    if (old_tile.empty || new_tile.empty) continue;
    const int u = tu * kTileSide, v = tv * kTileSide;
    if (old_pieces.by_plane(tu, tv) && new_pieces.by_plane(tu, tv)) {
      int a = 0;
      for (const Plane* p = &old_tile.first; p; p = p->next, a++) {
        int b = 0;
        for (const Plane* q = &new_tile.first; q; q = q->next, b++)
          if (share_a_node(*p, *q))
            overlaps(old_pieces.of_span(u, v, a), new_pieces.of_span(u, v, b));
      }
      continue;
    }
    for (int slot = 0; slot < kTileRays; slot++) {
      const int ray_u = u + slot % kTileSide, ray_v = v + slot / kTileSide;
      for_shared(
          RayWalk(old_tile, size_of(slot)), RayWalk(new_tile, size_of(slot)), [&](int a, int b) {
            overlaps(old_pieces.of_span(ray_u, ray_v, a), new_pieces.of_span(ray_u, ray_v, b));
          });
    }
  }
  return fates;
}

bool falls_apart(const Fates& fates) {
  return std::any_of(fates.begin(), fates.end(),
                     [](const auto& pieces) { return pieces.size() > 1; });
}

// The new pieces, grouped by the old piece they came from. The key is the first of each group.
std::map<int, std::vector<int>> grouped(const Fates& fates, size_t new_pieces) {
  std::vector<int> group(new_pieces);
  std::iota(group.begin(), group.end(), 0);
  const auto first_of = [&](int piece) {
    while (group[size_of(piece)] != piece) piece = group[size_of(piece)];
    return piece;
  };
  for (const std::vector<int>& pieces : fates)
    for (const int piece : pieces) {
      const int one = first_of(pieces.front()), other = first_of(piece);
      group[size_of(std::max(one, other))] = std::min(one, other);
    }
  std::map<int, std::vector<int>> groups;
  for (size_t piece = 0; piece < group.size(); piece++)
    groups[first_of(static_cast<int>(piece))].push_back(static_cast<int>(piece));
  return groups;
}

}  // namespace

Severed find_severed(const Snapshot& before, const Snapshot& after, int threads) {
  // The edit may have made the lattice larger.
  TriDexel larger(before, LatticeBox());
  larger.set_lattice(joined(before.lattice, after.lattice));
  const FieldSnapshot &was = larger.field(Axis::z).view(), &is = after.field(Axis::z);
  Severed severed;
  const TilePlaces places = changed_places(was, is);
  if (places.list.empty()) return severed;
  // If everything that was connected within these tiles is still connected, nothing was cut off. So
  // the other tiles are checked only if a connection is broken, or if there are few of them.
  const bool few_others = 4 * places.list.size() >= tiles_with_material(is);
  Pieces old_here, now;
  run_parallel(threads, 2, [&](size_t i) {
    if (i == 0)
      old_here = PieceFinder(was, &places.mask).take();
    else
      now = PieceFinder(is, few_others ? nullptr : &places.mask).take();
  });
  Fates fates = find_fates(was, old_here, is, now, places);
  if (!falls_apart(fates)) return severed;
  // In the other tiles nothing changed. So if two pieces were one before, they were connected
  // through these tiles.
  if (!few_others) {
    now = find_pieces(after);
    fates = find_fates(was, old_here, is, now, places);
  }
  for (const auto& [first, pieces] : grouped(fates, now.all().size())) {
    if (pieces.size() < 2) continue;
    int largest = first;
    double all = 0;
    for (const int piece : pieces) {
      const int64_t nodes = now.all()[size_of(piece)].nodes;
      all += static_cast<double>(nodes);
      if (nodes > now.all()[size_of(largest)].nodes) largest = piece;
    }
    for (const int piece : pieces)
      if (piece != largest)
        severed.parts.push_back(
            {piece, static_cast<double>(now.all()[size_of(piece)].nodes) / all});
  }
  if (!severed.parts.empty()) severed.pieces = std::move(now);
  return severed;
}

}  // namespace kibori
