// SPDX-License-Identifier: MIT
// The kernel's tolerances and limits, each with its unit, its reason, and what breaks if it
// changes. One lattice unit is one pitch. A tolerance that only one file needs is at the top of
// that file.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kibori {

// Maximum number of nodes along one axis of a lattice. At 8192, float32 depths resolve 1/2048 of a
// cell. The int32 node sums of one tile (nodes squared x 16 rows) stay below 2^31.
inline constexpr int kMaxNodesPerAxis = 8192;

// Maximum number of materials of a model; Removed's mask has one bit each.
inline constexpr int kMaxMaterials = 64;

// Tolerance for splitting a turn [lattice units]: within one tick, the tool's outermost point may
// differ by this from its true arc. A lattice cannot resolve a tenth of a cell. Ordinary ticks need
// 1 to 3 pieces.
inline constexpr double kTurnTolerance = 0.1;

// Maximum number of pieces of one turning tick. 4096 covers half a turn of a tool 100 cells long.
inline constexpr int kMaxTurnSubsteps = 4096;

// Maximum length of one piece of a straight motion [lattice units]. Longer pieces would lose digits
// in the quadratics of a sweep. Only ticks that move far past the stock are split for this reason.
inline constexpr double kMaxPieceLength = 4096;

// A tool's largest extent [lattice units]. Beyond it, float32 cannot resolve the tool's surface to
// 1/100 of a cell.
inline constexpr double kMaxToolReach = 32768;

// A turn smaller than this [rad] over one tick counts as no turn. It moves a tool of 8192 cells by
// less than a float32 depth can resolve.
inline constexpr double kNoTurn = 1e-9;

// A sweep shorter than this [lattice units] has no direction: the tool does not move. This is far
// below the resolution of a float32 depth (2^-11 at 8192). It is far above the length whose square
// underflows float64. If it is larger, slow motions cut in jumps. If it is smaller, directions are
// rounding error.
inline constexpr double kNoSweep = 1e-12;

// Sweeps longer than this [lattice units] are re-centred tile by tile. Therefore, float32 squares
// of distances stay below 2^18, and their rounding error below 1/32 of a depth's.
inline constexpr double kRecentreLength = 256.0;

// Rods are re-centred along their axis, tile by tile, if h^2 > kSlender * thickness [lattice
// units]. Here h is the tile's height on the rod plus the motion's length. The float32 error of the
// rod's surface is 2^-24 h^2 / thickness. At the limit, it equals the rounding of a depth at 512.
// If kSlender is smaller, tiles of every tool are re-centred. If it is larger, the fields of a thin
// rod disagree.
inline constexpr double kSlender = 1024.0;

// Slack [lattice units] around a solid's bounds when an edit decides what to skip. It exceeds the
// float32 rounding between bounds and intervals, so no ray is skipped wrongly.
inline constexpr double kBoundsSlack = 1.0 / 64;

// Sub-cell grid of scan conversion. Vertices snap to 2^-14 of a cell, the float32 spacing at depth
// 512. 8192 x 2^14 = 2^27, so the products of the edge functions stay below 2^56 in int64.
inline constexpr int kSnapBits = 14;

// A mesh is rejected as stock if more than this share of the rays that meet it are open
// (edit/scan_convert.h).
inline constexpr double kMaxBrokenShare = 0.5;

// Maximum distance of a lattice from the world's origin, in pitches. At this distance, float32 has
// 8 values per cell. The surface needs them to keep vertices apart (surface/chunk_worker.cpp).
inline constexpr double kMaxFromOrigin = 1 << 20;

// Maximum coordinate in a mesh file [mm]. Squares and products of three coordinates stay within
// float32.
inline constexpr double kMaxCoordinate = 1e12;

// Maximum number of triangles in a file. 100 million use about 5 GB of memory. Scanners do not
// produce more triangles in one piece.
inline constexpr size_t kMaxImportTriangles = 100'000'000;

// Used instead of infinity. A few additions and products of it do not overflow float32.
inline constexpr float kFar = 1e15f;

}  // namespace kibori
