// SPDX-License-Identifier: MIT
// The connected pieces of a model, and the pieces that an edit severed.
//
// Two lattice nodes belong to one piece if a path through inside nodes connects them. Each step of
// the path leads to one of a node's six neighbours. The z field decides which nodes are inside.
// Pieces that touch only at a corner or an edge are separate. In the surface, they are separate,
// too (docs/rooms/surface.md, "Sheets"). A span that contains no node belongs to no piece.
//
// find_pieces examines all tiles of the z field. find_severed examines only the tiles that changed,
// and their neighbours. It examines all tiles only if the material in these tiles fell apart.
#pragma once

#include <cstdint>
#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// A box of lattice nodes, from min to max, both included.
struct NodeBounds {
  Index3 min = Index3::Constant(kMaxNodesPerAxis), max = Index3::Constant(-kMaxNodesPerAxis);
  void include(const NodeBounds& other) {
    min = min.min(other.min);
    max = max.max(other.max);
  }
  bool empty() const { return (min > max).any(); }
  // True if the box meets a ray of the field `axis` in the rectangle from (u0, v0) to (u1, v1),
  // both included.
  bool meets(Axis axis, int u0, int v0, int u1, int v1) const {
    const int u = u_index(axis), v = v_index(axis);
    return min[u] <= u1 && max[u] >= u0 && min[v] <= v1 && max[v] >= v0;
  }
};

// A connected piece: its number of nodes and its bounds.
struct Piece {
  int64_t nodes = 0;  // number of its nodes
  NodeBounds box;
};

// All pieces of a model. Finds the piece of a node or of a span.
class Pieces {
 public:
  // The pieces are sorted by their first tile in the z field (by v, then u). Pieces with the same
  // first tile are sorted by their first ray in it, and then by depth.
  const std::vector<Piece>& all() const { return pieces_; }
  // Returns the index in all() of the piece that contains `node`; -1 if the node is outside. `z`
  // must be the field in which the pieces were found.
  int at(const FieldSnapshot& z, const Index3& node) const;
  // Returns the index in all() of the piece of a span of ray (u, v) of the z field; -1 if the span
  // contains no node. The spans of a ray count from 0.
  int of_span(int u, int v, int span) const;
  // True if each plane of a tile of the z field is known to belong to one piece: of_span then
  // returns the same for all rays of the tile.
  bool by_plane(int tu, int tv) const { return tiles_[tile_at(tu, tv)].by_plane; }

 private:
  friend class PieceFinder;
  struct TileLabels {
    int64_t first = -1;     // index into labels_; -1: the tile has no labels
    bool by_plane = false;  // true: one label per plane; false: one label per plane and slot
    size_t index(int span, size_t slot) const {
      const auto number = static_cast<size_t>(span);
      return static_cast<size_t>(first) + (by_plane ? number : number * kTileRays + slot);
    }
  };
  size_t tile_at(int tu, int tv) const {
    return static_cast<size_t>((tv - tv_begin_) * tiles_u_ + tu - tu_begin_);
  }
  int tu_begin_ = 0, tv_begin_ = 0, tiles_u_ = 0;
  std::vector<TileLabels> tiles_;
  std::vector<int> labels_;
  std::vector<Piece> pieces_;
};

// Finds all connected pieces of a model.
Pieces find_pieces(const Snapshot& model);

// Destinations of a piece that goes to no portion: it stays in the model, or it is dropped.
inline constexpr int kStays = -1, kGone = -2;
// Removes from a model the pieces that do not stay. `to` has the destination of each piece: the
// number of a portion, kStays or kGone. `pieces` must have been found in the model's current state.
// Returns the portions 0, 1, ... up to the highest number in `to`. Several pieces may go to one
// portion. The spans in the model and in the portions do not change, bit for bit. Spans that
// contain no node stay in the model.
std::vector<Snapshot> part_pieces(TriDexel& model, const Pieces& pieces, const std::vector<int>& to,
                                  int threads = 1);

// The pieces that an edit severed. After an edit, the nodes of one piece of `before` may be in
// several pieces. All of these pieces except the largest are severed. `parts` lists them.
struct Severed {
  struct Part {
    // Index in pieces.all().
    int piece = 0;
    // The number of its nodes, divided by the number of remaining nodes of all that it was
    // connected to in `before`.
    double share = 0;
  };
  Pieces pieces;  // the pieces of `after`; empty if nothing was severed
  std::vector<Part> parts;
};
Severed find_severed(const Snapshot& before, const Snapshot& after, int threads = 1);

}  // namespace kibori
