// SPDX-License-Identifier: MIT
// The kernel's tolerances and limits, each with its unit, its reason and what breaks when it is
// changed. One lattice unit is one pitch. A tolerance that a single file needs stands at the top of
// that file.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kibori {

// Nodes along one axis of a lattice. float32 depths keep 1/2048 of a cell at 8192, and the int32
// node sums of one tile (nodes squared x 16 rows) stay below 2^31.
inline constexpr int kMaxNodesPerAxis = 8192;

// Materials a model can hold; one bit each in Removed's mask.
inline constexpr int kMaxMaterials = 64;

// Turning split [lattice units]: within one tick the tool's outermost point may stray this far from
// its true arc. A tenth of a cell is below what a lattice of that pitch can show, and costs 1-3
// pieces in ordinary ticks.
inline constexpr double kTurnTolerance = 0.1;

// Pieces one turning tick may be split into; 4096 covers half a turn of a tool 100 cells long.
inline constexpr int kMaxTurnSubsteps = 4096;

// A straight motion is swept in pieces no longer than this [lattice units], so that the quadratics
// of a sweep keep their digits. Only ticks that fly far past the stock are ever so long.
inline constexpr double kMaxPieceLength = 4096;

// A tool's largest extent [lattice units]: beyond it float32 can't tell where its surface is to
// 1/100 of a cell.
inline constexpr double kMaxToolReach = 32768;

// A turn smaller than this [rad] over one tick moves a tool of 8192 cells by less than a float32
// depth can hold.
inline constexpr double kNoTurn = 1e-9;

// A sweep shorter than this [lattice units] has no direction: the tool stands. Far below what a
// float32 depth can hold (2^-11 at 8192), far above where the square of a length underflows a
// float64. Larger, and slow motions cut in jumps; smaller, and directions are divided by rounding.
inline constexpr double kNoSweep = 1e-12;

// Sweeps longer than this [lattice units] are re-centred tile by tile, so that float32 squares of
// distances stay below 2^18 and their rounding below 1/32 of a depth's own.
inline constexpr double kRecentreLength = 256.0;

// Rods are re-centred along their axis, tile by tile, where the square of how far up the tile is,
// the motion's length added, is more than so many times how thick they are [lattice units]: 2^-24
// of that square over the thickness is what float32 can put their surface off, a depth's own
// rounding at 512. Smaller, and tiles of every tool are re-centred; larger, and the fields of a
// thin rod come to differ.
inline constexpr double kSlender = 1024.0;

// Slack [lattice units] around a solid's bounds when they decide what an edit may pass by: more
// than float32 rounding can put between bounds and intervals, so what is passed by never shows.
inline constexpr double kBoundsSlack = 1.0 / 64;

// Sub-cell grid of scan conversion: vertices snap to 2^-14 of a cell, a quarter of the float32
// spacing at depth 512. 8192 x 2^14 = 2^27, so the products of the edge functions stay below 2^56
// in int64.
inline constexpr int kSnapBits = 14;

// A mesh is refused as stock when more than this share of the rays that meet it are open or
// disagree.
inline constexpr double kMaxBrokenShare = 0.5;

// A lattice's farthest coordinate from the world's origin, in pitches: beyond it float32 has less
// than 8 places a cell and could not keep vertices apart.
inline constexpr double kMaxFromOrigin = 1 << 20;

// Coordinates a mesh file may have [mm]: squares and products of three of them stay within float32.
inline constexpr double kMaxCoordinate = 1e12;

// Triangles a file may bring: 100 million take 5 GB as double vertices, more than any scanner makes
// in one piece.
inline constexpr size_t kMaxImportTriangles = 100'000'000;

// A stand-in for infinity that survives a few additions and products in float32.
inline constexpr float kFar = 1e15f;

}  // namespace kibori
