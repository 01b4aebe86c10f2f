// SPDX-License-Identifier: MIT
// The connected pieces of a model, and the pieces that an edit severed.
//
// Two lattice nodes belong to one piece if a path through material connects them, by steps to the
// six neighbours. The z field decides which nodes are inside. Pieces that touch only at a corner or
// an edge are separate, also in the surface (docs/rooms/surface.md, "Sheets"). A span that contains
// no node belongs to no piece.
//
// The time of find_pieces grows with the number of tiles of the z field. find_severed needs only
// the tiles that changed. It examines all tiles only if the material in the changed ones fell
// apart.
#pragma once

#include <cstdint>
#include <vector>

#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// Lattice nodes from min to max, both included.
struct NodeBounds {
  Index3 min = Index3::Constant(kMaxNodesPerAxis), max = Index3::Constant(-kMaxNodesPerAxis);
  void include(const NodeBounds& other) {
    min = min.min(other.min);
    max = max.max(other.max);
  }
  bool empty() const { return (min > max).any(); }
  // True if the box meets a ray of the field `axis` between (u0, v0) and (u1, v1), both included.
  bool meets(Axis axis, int u0, int v0, int u1, int v1) const {
    const int u = u_index(axis), v = v_index(axis);
    return min[u] <= u1 && max[u] >= u0 && min[v] <= v1 && max[v] >= v0;
  }
};

// A connected piece: its number of nodes and its bounds.
struct Piece {
  int64_t nodes = 0;  // inside nodes
  NodeBounds box;
};

// The pieces of a model. Finds the piece of a node or of a span.
class Pieces {
 public:
  // In the order of their first z tile (v, then u), of their first ray in it, then of depth.
  const std::vector<Piece>& all() const { return pieces_; }
  // Index in all() of the piece that contains a node; -1 if the node is outside. `z` must be the
  // field in which the pieces were found.
  int at(const FieldSnapshot& z, const Index3& node) const;
  // Index in all() of the piece of a span of a z ray. Spans of a ray count from 0.
  int of_span(int u, int v, int span) const;
  // True if each plane of a z tile belongs to one piece: of_span is the same for all its rays.
  bool by_plane(int tu, int tv) const { return tiles_[tile_at(tu, tv)].by_plane; }

 private:
  friend class PieceFinder;
  struct TileLabels {
    int64_t first = -1;     // in labels_; -1: the tile has none
    bool by_plane = false;  // one label per plane; otherwise one per plane and slot
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

// Destinations of a piece: portion 0, 1, ..., or one of these.
inline constexpr int kStays = -1, kGone = -2;
// Removes from a model the pieces that do not stay. `to` is the destination of each piece. `pieces`
// must have been found in the current model. Returns the portions, up to the highest number in
// `to`. Several pieces may go to one portion. The remaining material and the portions are
// unchanged, bit for bit. Spans that contain no node stay.
std::vector<Snapshot> part_pieces(TriDexel& model, const Pieces& pieces, const std::vector<int>& to,
                                  int threads = 1);

// The pieces that an edit has cut off. If the nodes of one piece of `before` are now in several
// pieces, all of these but the largest have been cut off. `parts` lists them by their numbers in
// `pieces`.
struct Severed {
  struct Part {
    int piece = 0;
    double share = 0;  // its nodes / the remaining nodes of all that it was connected to before
  };
  Pieces pieces;  // of `after`; empty if nothing was severed
  std::vector<Part> parts;
};
Severed find_severed(const Snapshot& before, const Snapshot& after, int threads = 1);

}  // namespace kibori
