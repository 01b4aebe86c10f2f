// SPDX-License-Identifier: MIT
// What is done to many rays, vertices or quads of a chunk at once, by vectors. Internal to
// `surface`.
//
// Each lane computes as the others do and as it would alone, so results depend neither on the
// vector's width nor on what else is in the batch. Batches are filled up to a multiple of kBatch.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <kibori/dexel/tile.h>

namespace kibori {

using Vec4f = Eigen::Vector4f;  // of which often three are used: as wide as a vector register

inline constexpr size_t kBatch = 16;

// Of the spans of one plane, those that begin and those that end in (least, most]: bit u of row v.
struct PlaneEnds {
  uint16_t in[kTileSide], out[kTileSide];
};

// A vertex's place in quanta: whole numbers within 2^24.
struct alignas(16) QuantizedPosition {
  int32_t x, y, z;
  int32_t rank;  // 1 on a smooth surface, 2 on a sharp edge, 3 in a corner
};

// One sheet of surface through a cell: sums over the ends of material on the edges it crosses,
// places counted from the cell's centre [lattice units].
struct SheetSums {
  Vec4f* points;    // w: how many
  Vec4f* normals;   // of unit length; w: how many are known
  Vec4f* products;  // points times normals along each axis
  // The cell's centre; x, y and z of `remainder` are in its rank, 3 bits each.
  QuantizedPosition* centres;
};

// Sheets that are one smooth face (all normals near their mean): `centres` becomes the vertex's
// place, at the given quanta a lattice unit, and `normals` its unit normal. Others get rank 0.
using PlaceSheets = void (*)(const SheetSums& sums, size_t count, float quanta);

// Vertices in order around a quad.
struct alignas(16) Quad {
  uint32_t v[4];
};
// Along which diagonal to split: first and third vertex, or second and fourth; or whether it needs
// a closer look, as a triangle is nearly degenerate.
enum Diagonal : int32_t { kFirstThird, kSecondFourth, kUnclear };
using ChooseDiagonals = void (*)(const Quad* quads, size_t count, const QuantizedPosition* places,
                                 int32_t* chosen);

using FindEnds = void (*)(const Plane& plane, float min, float max, PlaneEnds& ends);

// The nodes in each span of one plane: from ... to - 1, none if to <= from, counted from `first`
// and within [0, count].
struct PlaneNodes {
  alignas(64) int32_t from[kTileRays];
  alignas(64) int32_t to[kTileRays];
};
using FindNodes = void (*)(const Plane& plane, float first, float count, PlaneNodes& nodes);

// The best ones for this processor.
struct ChunkKernel {
  FindEnds find_ends;
  FindNodes find_nodes;
  PlaceSheets place_sheets;
  ChooseDiagonals choose_diagonals;
};
ChunkKernel chunk_kernel();

// The multiple of quanta next to n whose remainder by 8 is `wanted`.
inline int32_t with_remainder(int32_t n, int32_t wanted) { return n + ((wanted - n + 4) & 7) - 4; }

}  // namespace kibori
