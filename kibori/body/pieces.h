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

 private:
  friend class PieceFinder;
  struct TileLabels {
    int one = -1;        // all spans of the tile are of it; else -1
    int64_t first = -1;  // of labels_, by plane and slot; -1: no labels there
  };
  int tiles_u_ = 0;
  std::vector<TileLabels> tiles_;
  std::vector<int> labels_;
  std::vector<Piece> pieces_;
};

Pieces find_pieces(const Snapshot& model);

// Takes away all but the pieces that `keep` names (by their number in `pieces`, which were found in
// the model as it is); spans that hold no node stay where `keep_dust`. What stays is the same, bit
// for bit.
void keep_pieces(TriDexel& model, const Pieces& pieces, const std::vector<bool>& keep,
                 bool keep_dust);

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
Severed find_severed(const Snapshot& before, const Snapshot& after);

}  // namespace kibori
