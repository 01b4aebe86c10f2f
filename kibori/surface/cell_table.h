// SPDX-License-Identifier: MIT
// How the surface passes through one cell, from which of its eight corners are inside.
//
// Corner c of a cell has bit 0 set at the far x, bit 1 at the far y, bit 2 at the far z. Edge e = 4
// a + i runs along axis a; i counts the corners with bit a clear in ascending order. Face f = 2 a +
// side is square to axis a.
//
// The edges whose ends differ are crossed by the surface. On each face they are linked in pairs,
// and the links close to rings: each ring is one sheet of surface, with one vertex (dual marching
// cubes). On a face with inside and outside corners diagonal to each other there are two ways to
// link; the rule keeps inside corners apart. Where a ring then passes through such a face twice on
// both of its sides, two sheets would share a mesh edge, so there - and only there - the face is
// linked the other way ("flipped"). Tests go through all cases: flipping never makes a new such
// place.
#pragma once

#include <array>
#include <cstdint>

namespace kibori {

inline constexpr int kCellEdges = 12, kCellFaces = 6, kMaxSheets = 4;
inline constexpr uint8_t kNoSheet = 255;

// Corner at the near end of an edge, and its axis.
struct CellEdge {
  uint8_t corner, axis;
};
extern const std::array<CellEdge, kCellEdges> kEdges;

// The edge along `axis` whose near corner is `corner`.
constexpr int edge_at(int axis, int corner) {
  const int low = corner & ((1 << axis) - 1), high = corner >> (axis + 1);
  return 4 * axis + (high << axis | low);
}

struct CellSheets {
  // The sheet that crosses the edge; kNoSheet where none does.
  std::array<uint8_t, kCellEdges> of_edge;
  std::array<uint8_t, kCellEdges> edges;      // those that are crossed, sheet by sheet
  std::array<uint8_t, kMaxSheets + 1> begin;  // of each sheet in `edges`
  uint8_t count;
  uint8_t twice;  // faces that one sheet passes through twice, one bit each
};

// Sheets of a cell by its inside corners (one bit each), no face flipped.
const CellSheets& sheets_of(uint8_t inside);

// The same with the faces in `flipped` linked the other way; only faces in `twice` may be.
CellSheets sheets_of(uint8_t inside, uint8_t flipped);

}  // namespace kibori
