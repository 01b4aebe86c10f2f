// SPDX-License-Identifier: MIT
// The vectorised part of NodeBand: computations on 16 nodes at once.
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
  size_t margin;            // empty blocks that the scratch memory has before and after each row
  size_t window;            // maximum number of nodes from an end to a node that may use it
  float farthest, too_far;  // maximum useful distance of an end; |d|^2 of a node without an end

  // The ends of the slice's rays. For y and z rays they are in layers, by blocks of rays, and
  // `depth` is the slice's depth along the rays. For x rays there are no layers. The ends are in
  // lists for single rays, and `depth` belongs to the first lane.
  const detail::RayItems* rays;
  const detail::EndLayer* layers;
  const SurfaceEnd* ends;
  float depth, length;  // of the slice's first node, and from it to the last
  const detail::DepthRange *row_ends, *ray_ends;  // of each row, and of each block of rays

  detail::BandScratch* scratch;

  // Data of the band, one element per block.
  detail::FloatRow* distance2;
  detail::IndexRow* nearest;
  uint16_t* known;
  const uint16_t* wanted;  // null: all nodes are wanted
  size_t first, row_step, col_step;
  // For rows and blocks: the square of their distance from the brush's centre along one axis, minus
  // BandPart::around. For ends, `farthest` is subtracted from the distance too, because an end can
  // serve a node that is nearer to the centre. `away` is the same for the slice, `reach2` the
  // maximum sum of the three.
  const float *row_away, *col_away, *row_ends_away, *col_ends_away;
  float away, reach2;

  // True if ends at those depths are within reach of the slice.
  bool near(const detail::DepthRange& range) const {
    return depth + length >= range.low - farthest && depth <= range.high + farthest;
  }
};

// A plane of nodes with one z. compute_sides decides which of them are inside.
struct BandPlane {
  size_t rows, blocks, nx;
  float z;
  float width;
  const detail::RayItems* rays;
  const detail::BandSpans* spans;
  float* phi;
  const float *row_away, *block_away;  // as in BandSlice
  float away, reach2;
  const uint16_t* wanted;
  const detail::RowRange* computed;  // of each row; null: all
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

// Nodes whose phi may change. None of them is in a row at the box's border.
struct ChangedBlocks {
  const NodeBlock* blocks;
  size_t count;
  const float *phi, *after;  // of the box
  Index3 low, high;          // nodes of the lattice
};

// Nodes that a collar of clay may raise: see clay.h.
struct CollarBlocks {
  NodeBlock* blocks;  // output: only the nodes that rise
  size_t count;
  const float *phi, *path_phi;  // of the box; distances to the tool's sweep
  Vec3 centre;                  // [lattice units]
  double radius, ramp;
  detail::FloatRow* weights;  // of each block's nodes; 0 for the others
  double* areas;              // of each block's surface, weighted
};

struct BandKernels {
  // Finds the nodes' nearest ends on the slice's rays.
  void (*search)(const BandSlice&);
  // Sets the nodes to -width (inside) or width (outside).
  void (*compute_sides)(const BandPlane&);
  // phi of nodes whose nearest end is known.
  void (*measure)(const MeasuredBlocks&);
  // Volume that the change adds. The inside share of a node's cell goes from 0 to 1 while the
  // surface moves by one cell past it.
  double (*added_volume)(const ChangedBlocks&);
  // A collar's weights.
  void (*weigh_collar)(const CollarBlocks&);
  // Masks of 16 nodes: those with |phi| < depth; those whose two values differ.
  uint32_t (*nodes_within_depth)(const float* phi, float depth);
  uint32_t (*nodes_that_differ)(const float* one, const float* two);
  // A filter along an axis: to[i] = kernel[0] low[0][i] + the sum over m of kernel[m] (low[m][i] +
  // high[m][i]), for i < count. `count` is at least 16.
  void (*sum_rows)(const float* const* low, const float* const* high,
                   const std::vector<float>& kernel, size_t count, float* to);
};
// The kernels for the best instruction set of this machine.
BandKernels band_kernels();

}  // namespace kibori
