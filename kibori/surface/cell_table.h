// SPDX-License-Identifier: MIT
// How the surface passes through one cell, computed from the set of its corners that are inside.
//
// Corner c of a cell has bit 0 set at the far x, bit 1 at the far y, bit 2 at the far z. Edge e = 4
// a + i runs along axis a. The index i counts the corners with bit a clear in ascending order. Face
// f = 2 a + side is perpendicular to axis a.
//
// The surface crosses the edges whose two ends differ. On each face, these edges are linked in
// pairs, and the links close to rings. Each ring is one sheet of surface with one vertex (dual
// marching cubes).
//
// A face is ambiguous if its two inside corners are diagonal to each other. Its edges can then be
// linked in two ways, and the rule keeps the inside corners apart. There is one exception: in both
// cells of the face, one ring passes through the face twice. Then two quads would share an edge, so
// the face is linked the other way ("flipped"). Tests check all cases: a flip never makes another
// flip necessary.
#pragma once

#include <array>
#include <cstdint>

namespace kibori {

inline constexpr int kCellEdges = 12, kCellFaces = 6, kMaxSheets = 4;
inline constexpr uint8_t kNoSheet = 255;

// The corner at the near end of an edge, and the edge's axis.
struct CellEdge {
  uint8_t corner, axis;
};
extern const std::array<CellEdge, kCellEdges> kEdges;

// The edge along `axis` whose near corner is `corner`.
constexpr int edge_at(int axis, int corner) {
  const int low = corner & ((1 << axis) - 1), high = corner >> (axis + 1);
  return 4 * axis + (high << axis | low);
}

// The sheets of surface through one cell.
struct CellSheets {
  // The sheet that crosses each edge; kNoSheet if none does.
  std::array<uint8_t, kCellEdges> of_edge;
  std::array<uint8_t, kCellEdges> edges;      // crossed edges, sheet by sheet
  std::array<uint8_t, kMaxSheets + 1> begin;  // of each sheet in `edges`
  uint8_t count;
  uint8_t twice;  // faces that one sheet passes through twice, one bit each
};

// The sheets of a cell with these inside corners (one bit each), if no face is flipped.
const CellSheets& sheets_of(uint8_t inside);

// The same with the faces in `flipped` linked the other way. `flipped` must be a subset of `twice`.
CellSheets sheets_of(uint8_t inside, uint8_t flipped);

}  // namespace kibori
