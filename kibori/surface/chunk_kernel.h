// SPDX-License-Identifier: MIT
// Vector functions that process many rays, vertices or quads of a chunk at once. Internal to
// `surface`.
//
// The result of a lane does not depend on other lanes. Therefore, it depends neither on the vector
// width, nor on the rest of the batch. The size of a batch is padded to a multiple of kBatch.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <kibori/dexel/tile.h>

namespace kibori {

using Vec4f = Eigen::Vector4f;  // as wide as a vector register; often only three are used

inline constexpr size_t kBatch = 16;

// The ends of one plane's spans in (min, max]. Bit u of in[v] is set if the span of ray (u, v)
// begins there. Bit u of out[v] is set if it ends there.
struct PlaneEnds {
  uint16_t in[kTileSide], out[kTileSide];
};

// A vertex's position in quanta, as integers up to 2^24. A quantum is the spacing of vertex
// coordinates.
struct alignas(16) QuantizedPosition {
  int32_t x, y, z;
  int32_t rank;  // 1 on a smooth surface, 2 on a sharp edge, 3 in a corner
};

// Data for several sheets; a sheet is one part of the surface in a cell. The sums of a sheet are
// over the ends of material on the cell's edges that the sheet crosses. Positions are relative to
// the cell's centre [lattice units].
struct SheetSums {
  Vec4f* points;    // sum of the points; w: number of points
  Vec4f* normals;   // sum of the known unit normals; w: number of them
  Vec4f* products;  // sum of points times normals, for each axis
  // The cell's centre. As input, `rank` holds the wanted remainders of x, y and z modulo 8, 3 bits
  // each.
  QuantizedPosition* centres;
};

// Handles sheets that are one smooth face (all normals are near their mean). Replaces `centres` by
// the vertices' positions, and `normals` by their unit normals. `quanta`: number of quanta per
// lattice unit. All other sheets get rank 0.
using PlaceSheets = void (*)(const SheetSums& sums, size_t count, float quanta);

// The vertices of a quad, in order around it.
struct alignas(16) Quad {
  uint32_t v[4];
};
// The diagonal along which a quad is split: between the first and the third vertex, or between the
// second and the fourth. kUnclear: a triangle is nearly degenerate, and the caller must check
// exactly.
enum Diagonal : int32_t { kFirstThird, kSecondFourth, kUnclear };
using ChooseDiagonals = void (*)(const Quad* quads, size_t count, const QuantizedPosition* places,
                                 int32_t* chosen);

// Fills `ends` for one plane of a tile.
using FindEnds = void (*)(const Plane& plane, float min, float max, PlaneEnds& ends);

// The nodes in each span of one plane: `from` to `to` - 1. If to <= from, there are none. Indices
// of nodes are relative to `first`, and clamped to [0, count].
struct PlaneNodes {
  alignas(64) int32_t from[kTileRays];
  alignas(64) int32_t to[kTileRays];
};
using FindNodes = void (*)(const Plane& plane, float first, float count, PlaneNodes& nodes);

// The functions for the best vector unit of this processor.
struct ChunkKernel {
  FindEnds find_ends;
  FindNodes find_nodes;
  PlaceSheets place_sheets;
  ChooseDiagonals choose_diagonals;
};
ChunkKernel chunk_kernel();

// Returns the integer nearest to n whose remainder modulo 8 is `wanted`.
inline int32_t with_remainder(int32_t n, int32_t wanted) { return n + ((wanted - n + 4) & 7) - 4; }

}  // namespace kibori
