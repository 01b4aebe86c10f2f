// SPDX-License-Identifier: MIT
// Tolerances and limits of the kernel, with their units and reasons. Some comments also say what
// goes wrong with another value. One lattice unit is one pitch. A tolerance that only one file
// needs is at the top of that file.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kibori {

// Maximum number of nodes along one axis of a lattice. Below a depth of 8192, float32 resolves
// 1/2048 of a cell. The int32 sums of node indices in a tile, at most 8192^2 x 16, stay below 2^31.
inline constexpr int kMaxNodesPerAxis = 8192;

// Maximum number of materials of a model. The mask in Removed (edit/removed.h) has one bit for
// each.
inline constexpr int kMaxMaterials = 64;

// A tick that turns the tool is divided into substeps, in which the tool keeps its orientation. The
// tool's outermost point may then differ from its true arc by at most this distance [lattice
// units]. A lattice cannot resolve a tenth of a cell. Ordinary ticks need 1 to 3 substeps.
inline constexpr double kTurnTolerance = 0.1;

// Maximum number of substeps of one tick. 4096 are enough for half a turn of a tool 100 cells long.
inline constexpr int kMaxTurnSubsteps = 4096;

// Maximum length of one piece of a straight motion [lattice units]. In a longer piece, the
// quadratics of a sweep would lose digits. Only a tick that moves far past the stock is split.
inline constexpr double kMaxPieceLength = 4096;

// Maximum extent of a tool [lattice units]. For a larger tool, float32 cannot resolve the surface
// to 1/100 of a cell.
inline constexpr double kMaxToolReach = 32768;

// If the tool turns by less than this in one tick [rad], the turn is ignored. Such a turn moves the
// end of a tool of 8192 cells by less than a float32 depth can resolve.
inline constexpr double kNoTurn = 1e-9;

// If a sweep is shorter than this [lattice units], the tool counts as not moving. The length is far
// below the resolution of a float32 depth (2^-11 at 8192). Its square is far above the smallest
// float64. With a larger value, slow motions would cut in jumps. With a smaller value, directions
// would be rounding error.
inline constexpr double kNoSweep = 1e-12;

// If a sweep is longer than this [lattice units], it is re-centred: each tile has an origin of
// coordinates near the tile. Then float32 squares of distances stay below 2^18, and their rounding
// errors below 1/32.
inline constexpr double kRecentreLength = 256.0;

// A rod is re-centred along its axis, too, where h^2 > kSlender * thickness [lattice units]. Here h
// is the tile's height on the rod plus the motion's length. The float32 error of the rod's surface
// is 2^-24 h^2 / thickness. At the limit, this equals the rounding of a depth at 512. With a
// smaller value, tiles of every tool would be re-centred. With a larger value, the three fields of
// a thin rod would disagree.
inline constexpr double kSlender = 1024.0;

// Slack around a solid's bounds [lattice units]. An edit skips what is outside of bounds and slack.
// Bounds and intervals differ by float32 rounding, which is smaller than the slack. Therefore, the
// edit never skips a ray that it must change.
inline constexpr double kBoundsSlack = 1.0 / 64;

// Scan conversion rounds vertices to a grid of 2^-kSnapBits cells. 2^-14 is the spacing of float32
// at depth 512. Coordinates are at most 8192 x 2^14 = 2^27 grid units. Therefore, the products in
// the edge functions stay below 2^56 and fit into int64.
inline constexpr int kSnapBits = 14;

// Maximum share of open rays among the rays that meet a mesh (edit/scan_convert.h). A mesh with a
// larger share is rejected as stock.
inline constexpr double kMaxBrokenShare = 0.5;

// Maximum distance of a lattice from the world's origin [pitches]. At this distance, float32 has 8
// values per cell. The surface needs these values to keep vertices apart
// (surface/chunk_worker.cpp).
inline constexpr double kMaxFromOrigin = 1 << 20;

// Maximum size of a coordinate in a mesh file [mm]. Squares of coordinates, and products of three
// coordinates, stay within the range of float32.
inline constexpr double kMaxCoordinate = 1e12;

// Maximum number of triangles in a file. 100 million triangles use about 5 GB of memory. Scanners
// do not produce more in one piece.
inline constexpr size_t kMaxImportTriangles = 100'000'000;

// Replaces infinity. A few additions and multiplications of this value do not overflow float32.
inline constexpr float kFar = 1e15f;

}  // namespace kibori
