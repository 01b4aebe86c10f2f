// SPDX-License-Identifier: MIT
// The vector instructions of NodeBand: computations on 16 nodes at once. node_band.h defines bands,
// blocks, sides and known distances.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <kibori/reshape/node_band.h>

namespace kibori {

// The search for nearest ends in one slice of nodes. The slice has rows of blocks. A block has 16
// nodes.
struct BandSlice {
  size_t rows, cols;
  size_t step;              // number of lanes from a node to the next node of its row
  size_t margin;            // empty blocks before and after each row in the scratch memory
  size_t window;            // maximum distance of an end from a node that may use it, in nodes
  float farthest, too_far;  // farthest: max distance of a useful end; too_far: |d|^2 without an end

  // The ends of the slice's rays. For y and z rays, `layers` has the ends of blocks of rays, and
  // `depth` is the depth of the slice. For x rays, `layers` is null, `rays` has ranges in `ends`,
  // and `depth` is the depth of the first lane.
  const detail::RayItems* rays;
  const detail::EndLayer* layers;
  const SurfaceEnd* ends;
  float depth, length;  // depth of the first node; distance from the first to the last node
  const detail::DepthRange *row_ends, *ray_ends;  // depths of the ends in each row, each block

  detail::BandScratch* scratch;

  // Data of the band: one element per block.
  detail::FloatRow* distance2;
  detail::IndexRow* nearest;
  uint16_t* known;
  const uint16_t* wanted;  // null: all nodes are wanted
  size_t first, row_step, col_step;
  // Squared distances from the brush's centre along one axis. BandPart::around is subtracted before
  // squaring. `row_away` and `col_away` are for the nodes of rows and of blocks, `away` for the
  // slice. In the values for ends, `farthest` is subtracted too, because an end can serve a node
  // that is nearer to the centre. `reach2` is the maximum sum of the three.
  const float *row_away, *col_away, *row_ends_away, *col_ends_away;
  float away, reach2;

  // Returns true if nodes of the slice can use ends at these depths.
  bool near(const detail::DepthRange& range) const {
    return depth + length >= range.low - farthest && depth <= range.high + farthest;
  }
};

// A plane of nodes with the same z. compute_sides() finds which of them are inside.
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
  const detail::RowRange* computed;  // range of each row to compute; null: all nodes
};

// Nodes whose nearest ends are known. measure() computes their phi.
struct MeasuredBlocks {
  const NodeBlock* blocks;
  size_t count;
  const SurfaceEnd* ends;
  const detail::IndexRow* nearest;
  float width;
  float* phi;
};

// Nodes whose phi may change. None of them is at the border of the box.
struct ChangedBlocks {
  const NodeBlock* blocks;
  size_t count;
  const float *phi, *after;  // values for all nodes of the box
  Index3 low, high;          // range of the lattice's nodes
};

// Nodes that a collar of clay may raise (clay.h).
struct CollarBlocks {
  NodeBlock* blocks;  // input: candidates; output: only the nodes that rise
  size_t count;
  // Signed distances to the surface, and to the tool's sweep.
  const float *phi, *path_phi;
  Vec3 centre;  // [lattice units]
  double radius, ramp;
  detail::FloatRow* weights;  // one per block; 0 for nodes that do not rise
  double* areas;              // weighted area of the surface in each block
};

struct BandKernels {
  // Finds the nearest ends of the slice's nodes on the slice's rays.
  void (*search)(const BandSlice&);
  // Sets phi to -width for nodes inside, and to width for nodes outside.
  void (*compute_sides)(const BandPlane&);
  // Computes phi of nodes whose nearest end is known.
  void (*measure)(const MeasuredBlocks&);
  // Returns the volume that the change adds [cells^3]. While the surface moves by one cell past a
  // node, the share of the node's cell that is inside goes from 0 to 1.
  double (*added_volume)(const ChangedBlocks&);
  // Computes the weights of a collar.
  void (*weigh_collar)(const CollarBlocks&);
  // Return one bit for each of 16 nodes: nodes with |phi| < depth; nodes whose two values differ.
  uint32_t (*nodes_within_depth)(const float* phi, float depth);
  uint32_t (*nodes_that_differ)(const float* one, const float* two);
  // Filters along an axis, for i < count: to[i] = kernel[0] low[0][i] + the sum over m > 0 of
  // kernel[m] (low[m][i] + high[m][i]). `count` must be at least 16.
  void (*sum_rows)(const float* const* low, const float* const* high,
                   const std::vector<float>& kernel, size_t count, float* to);
};
// Returns the kernels for the best vector unit of this machine.
BandKernels band_kernels();

}  // namespace kibori
