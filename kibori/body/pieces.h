// SPDX-License-Identifier: MIT
// The connected pieces of a model, and what an edit severed.
//
// Two lattice nodes are of one piece where a way of steps to the six neighbours leads from one to
// the other through material: so says the z field, which decides what is inside. The surface never
// joins across a corner or an edge what is not joined so, except where a face between cells forces
// it (docs/architecture.md, "Sheets"). A span that holds no node is of no piece.
//
// Costs: find_pieces goes by the z field's tiles; find_severed by the tiles that changed, unless
// the material around them fell apart there.
#pragma once

#include <cstdint>
#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// Lattice nodes, from min to max, both included.
struct NodeBounds {
  Index3 min = Index3::Constant(kMaxNodesPerAxis), max = Index3::Constant(-1);
  void include(const NodeBounds& other) {
    min = min.min(other.min);
    max = max.max(other.max);
  }
  bool empty() const { return (min > max).any(); }
  // Whether rays of the field `axis` between (u0, v0) and (u1, v1), both included, meet it.
  bool meets(Axis axis, int u0, int v0, int u1, int v1) const {
    const int u = u_index(axis), v = v_index(axis);
    return min[u] <= u1 && max[u] >= u0 && min[v] <= v1 && max[v] >= v0;
  }
};

struct Piece {
  int64_t nodes = 0;  // that are inside it
  NodeBounds box;
};

class Pieces {
 public:
  // In the order of their first z ray (v, then u), then of depth.
  const std::vector<Piece>& all() const { return pieces_; }
  // Which of all() holds a node; -1: it is outside. `model` as it was found in.
  int at(const FieldSnapshot& z, const Index3& node) const;
  // Which of all() a span of a z ray belongs to: the number of the span on the ray counts from 0.
  int of_span(int u, int v, int span) const;
  // Whether each plane of a z tile is of one piece: of_span is the same for all its rays.
  bool by_plane(int tu, int tv) const { return tiles_[tile_at(tu, tv)].by_plane; }

 private:
  friend class PieceFinder;
  struct TileLabels {
    int64_t first = -1;     // of labels_; -1: the tile has none
    bool by_plane = false;  // one a plane; else one a plane and slot
    size_t index(int span, size_t slot) const {
      const auto number = static_cast<size_t>(span);
      return static_cast<size_t>(first) + (by_plane ? number : number * kTileRays + slot);
    }
  };
  size_t tile_at(int tu, int tv) const { return static_cast<size_t>(tv * tiles_u_ + tu); }
  int tiles_u_ = 0;
  std::vector<TileLabels> tiles_;
  std::vector<int> labels_;
  std::vector<Piece> pieces_;
};

Pieces find_pieces(const Snapshot& model);

// Where a piece goes that does not become portion 0, 1, ...
inline constexpr int kStays = -1, kGone = -2;
// Takes from a model the pieces that do not stay. `to`: of each of `pieces`, which were found in
// the model as it is, where it goes. Returns the portions, up to the highest number in `to`;
// several pieces may go to one. What stays, with the spans that hold no node, and what the portions
// hold is as it was, bit for bit.
std::vector<Snapshot> part_pieces(TriDexel& model, const Pieces& pieces, const std::vector<int>& to,
                                  int threads = 1);

// What an edit between two states of a model severed: a piece of `before` whose nodes are now in
// several pieces. Each of them but the largest is named, by its number in `pieces`.
struct Severed {
  struct Part {
    int piece = 0;
    double share = 0;  // of the nodes of all the pieces it comes from
  };
  Pieces pieces;  // of `after`; not found where nothing was severed
  std::vector<Part> parts;
};
Severed find_severed(const Snapshot& before, const Snapshot& after, int threads = 1);

}  // namespace kibori
