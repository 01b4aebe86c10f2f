// SPDX-License-Identifier: MIT
// Vector functions on many rays, vertices or quads of a chunk at once. Internal to `surface`.
//
// The result of a lane does not depend on other lanes. Therefore, results depend neither on the
// vector width nor on the rest of the batch. Batches are padded to a multiple of kBatch.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <kibori/dexel/tile.h>

namespace kibori {

using Vec4f = Eigen::Vector4f;  // as wide as a vector register; often only three are used

inline constexpr size_t kBatch = 16;

// Spans with an end in (min, max], for one plane. Bit u of in[v]: the span of ray (u, v) begins
// there. Bit u of out[v]: it ends there.
struct PlaneEnds {
  uint16_t in[kTileSide], out[kTileSide];
};

// A vertex's position in quanta: integers up to 2^24.
struct alignas(16) QuantizedPosition {
  int32_t x, y, z;
  int32_t rank;  // 1 on a smooth surface, 2 on a sharp edge, 3 in a corner
};

// One sheet of surface through a cell: sums over the ends of material on the edges that it crosses.
// Positions are relative to the cell's centre [lattice units].
struct SheetSums {
  Vec4f* points;    // w: number of points
  Vec4f* normals;   // of unit length; w: number of known normals
  Vec4f* products;  // points times normals along each axis
  // The cell's centre. As input, `rank` holds the remainders of x, y and z, 3 bits each.
  QuantizedPosition* centres;
};

// Handles sheets that are one smooth face (all normals near their mean). Sets `centres` to the
// vertex's position, and `normals` to its unit normal. `quanta`: per lattice unit. Other sheets get
// rank 0.
using PlaceSheets = void (*)(const SheetSums& sums, size_t count, float quanta);

// Vertices in order around a quad.
struct alignas(16) Quad {
  uint32_t v[4];
};
// The diagonal along which to split: first and third vertex, or second and fourth. kUnclear means
// that a triangle is nearly degenerate, and the caller must check exactly.
enum Diagonal : int32_t { kFirstThird, kSecondFourth, kUnclear };
using ChooseDiagonals = void (*)(const Quad* quads, size_t count, const QuantizedPosition* places,
                                 int32_t* chosen);

// Fills `ends` for one plane of a tile.
using FindEnds = void (*)(const Plane& plane, float min, float max, PlaneEnds& ends);

// The nodes in each span of one plane: from ... to - 1; none if to <= from. Indices of nodes are
// relative to `first`, and clamped to [0, count].
struct PlaneNodes {
  alignas(64) int32_t from[kTileRays];
  alignas(64) int32_t to[kTileRays];
};
using FindNodes = void (*)(const Plane& plane, float first, float count, PlaneNodes& nodes);

// The functions for the widest vector unit of this processor.
struct ChunkKernel {
  FindEnds find_ends;
  FindNodes find_nodes;
  PlaceSheets place_sheets;
  ChooseDiagonals choose_diagonals;
};
ChunkKernel chunk_kernel();

// The integer nearest to n whose remainder by 8 is `wanted`.
inline int32_t with_remainder(int32_t n, int32_t wanted) { return n + ((wanted - n + 4) & 7) - 4; }

}  // namespace kibori
