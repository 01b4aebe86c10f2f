// SPDX-License-Identifier: MIT
// How the surface passes through one cell. It depends only on which corners of the cell are inside.
//
// The bits of a corner's number say where the corner is. Bit 0 is set at the far x, bit 1 at the
// far y, and bit 2 at the far z. Edge e = 4 a + i runs along axis a. The index i counts the four
// corners whose bit a is clear, in ascending order; the edge begins at this corner. Face f = 2 a +
// side is perpendicular to axis a.
//
// The surface crosses an edge if one end of the edge is inside and the other is not. On each face,
// the crossed edges are linked in pairs. The links form closed rings. Each ring is one sheet of the
// surface, and has one vertex (dual marching cubes).
//
// A face is ambiguous if exactly two of its corners are inside, and they are diagonal to each
// other. Its edges can then be linked in two ways. By the rule, the links keep the inside corners
// apart. There is one exception: in each of the two cells of the face, one ring passes through the
// face twice. Then two quads would share an edge. Therefore, the face is linked the other way
// ("flipped"). Tests check all cases: a flip never makes another flip necessary.
#pragma once

#include <array>
#include <cstdint>

namespace kibori {

inline constexpr int kCellEdges = 12, kCellFaces = 6, kMaxSheets = 4;
inline constexpr uint8_t kNoSheet = 255;

// An edge of a cell: its axis, and the corner at its near end.
struct CellEdge {
  uint8_t corner, axis;
};
extern const std::array<CellEdge, kCellEdges> kEdges;

// Returns the edge along `axis` whose near corner is `corner`.
constexpr int edge_at(int axis, int corner) {
  const int low = corner & ((1 << axis) - 1), high = corner >> (axis + 1);
  return 4 * axis + (high << axis | low);
}

// The sheets of surface through one cell.
struct CellSheets {
  // The sheet that crosses each edge; kNoSheet if none does.
  std::array<uint8_t, kCellEdges> of_edge;
  std::array<uint8_t, kCellEdges> edges;      // crossed edges, sheet by sheet
  std::array<uint8_t, kMaxSheets + 1> begin;  // index in `edges` where each sheet begins
  uint8_t count;
  uint8_t twice;  // faces that one sheet passes through twice, one bit each
};

// Returns the sheets of a cell. `inside` has one bit for each inside corner. No face is flipped.
const CellSheets& sheets_of(uint8_t inside);

// The same, but the faces in `flipped` are linked the other way. `flipped` must be a subset of
// CellSheets::twice.
CellSheets sheets_of(uint8_t inside, uint8_t flipped);

}  // namespace kibori
