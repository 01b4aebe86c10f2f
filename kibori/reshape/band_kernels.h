// SPDX-License-Identifier: MIT
// The vector part of NodeBand: what is computed of 16 nodes at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <kibori/reshape/node_band.h>

namespace kibori {

// A slice of nodes: rows of blocks, 16 nodes each.
struct BandSlice {
  size_t rows, cols;
  size_t step;              // lanes from a node to the next in its row
  size_t margin;            // blocks without ends at both ends of a row; window + 1 such rows
  size_t window;            // of nodes within reach
  float farthest, too_far;  // an end's distance, and its square

  // Its rays' ends: by blocks in layers, `depth` along them; or, if there are no layers, along the
  // block's lanes, of which the first is at `depth`.
  const detail::RayItems* rays;
  const detail::EndLayer* layers;
  const SurfaceEnd* ends;
  float depth, length;  // of the slice's first node, and from it to the last
  const detail::DepthRange *row_ends, *ray_ends;  // of each row, and of each block of rays

  detail::BandScratch* scratch;

  // Of the band, by blocks.
  detail::FloatRow* distance2;
  detail::IndexRow* nearest;
  uint16_t* known;
  const uint16_t* wanted;  // null: all are
  size_t first, row_step, col_step;
  // Squared distances from the brush's centre by axis: of nodes, and of the nodes nearest to it
  // that a ray's ends may be nearest to.
  const float *row_away, *col_away, *row_ends_away, *col_ends_away;
  float away, reach2;

  // Whether ends of those depths are within reach of the slice.
  bool near(const detail::DepthRange& range) const {
    return depth + length >= range.low - farthest && depth <= range.high + farthest;
  }
};

// Whose sides are to be told: the nodes of a plane across z.
struct BandPlane {
  size_t rows, blocks, nx;
  float z;
  float width;
  const detail::RayItems* rays;
  const detail::BandSpans* spans;
  float* phi;
  const float *row_away, *block_away;  // as of a slice
  float away, reach2;
  const uint16_t* wanted;
  const detail::RowRange* told;  // of each row; null: all
};

// Nodes whose nearest ends are known.
struct MeasuredBlocks {
  const NodeBlock* blocks;
  size_t count;
  const SurfaceEnd* ends;
  const detail::IndexRow* nearest;
  float width;
  float* phi;
};

// Nodes whose phi may change: of no row at the box's border.
struct ChangedBlocks {
  const NodeBlock* blocks;
  size_t count;
  const float *phi, *after;  // of the box
  size_t stride_y, stride_z;
  Index3 nodes;  // of the lattice
};

// Nodes that a collar of clay may raise: see clay.h.
struct CollarBlocks {
  NodeBlock* blocks;  // are left the nodes that rise
  size_t count;
  const float *phi, *way_phi;  // of the box; distances to the tool's way
  Vec3 centre;                 // [lattice units]
  double radius, ramp;
  detail::FloatRow* weights;  // of each block's nodes; 0 of the others
  double* areas;              // of each block's surface, weighed
};

struct BandKernels {
  // Finds the nodes' nearest ends on the slice's rays.
  void (*search)(const BandSlice&);
  // Which nodes are inside, as -width or width.
  void (*tell_sides)(const BandPlane&);
  // phi of nodes whose nearest end is known.
  void (*measure)(const MeasuredBlocks&);
  // Volume that the change adds, as lengths along the lines through the nodes that lie between the
  // zeros of phi, which is taken to be linear from node to node: the sum over the three axes.
  double (*added_volume)(const ChangedBlocks&);
  // A collar's weights.
  void (*weigh_collar)(const CollarBlocks&);
  // Of 16 nodes, those with |phi| < depth; those of which two values differ.
  uint32_t (*nodes_within_depth)(const float* phi, float depth);
  uint32_t (*nodes_that_differ)(const float* one, const float* two);
  // A filter along an axis: to[i] = kernel[0] low[0][i] + the sum over m of
  // kernel[m] (low[m][i] + high[m][i]), for i < count, which is 16 at least.
  void (*sum_rows)(const float* const* low, const float* const* high,
                   const std::vector<float>& kernel, size_t count, float* to);
};
// For this machine's best instructions.
BandKernels band_kernels();

}  // namespace kibori
