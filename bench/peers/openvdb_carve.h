// SPDX-License-Identifier: MIT
// The peer: carving with OpenVDB, as an expert would write it. It stamps the ball into a sparse
// grid, leaf by leaf.
#pragma once

#include "bench/workload.h"

namespace kibori_bench {

// Carves a narrow-band level set (distances, half-width 3): computes max(a, R - d) in the leaves of
// the tool's box. Uses AVX-512 if the compiler may.
StepTimes openvdb_levelset_stamp(int n, const std::vector<Point>& path, float radius);
// Carves a grid of one bit per voxel, without sub-cell geometry.
StepTimes openvdb_bitmask_stamp(int n, const std::vector<Point>& path, float radius);
// Carves by tools::csgDifference with a new level-set sphere for each step.
StepTimes openvdb_csg_difference(int n, const std::vector<Point>& path, float radius);
// Carves a level set. From step `from` on, times tools::volumeToMesh on the leaves around the ball.
// The leaves are copied, so that carving can continue. `triangles`: the median of a step.
StepTimes openvdb_local_remesh(int n, const std::vector<Point>& path, float radius, int from,
                               double* triangles);
// Converts a mesh into a signed distance field of n voxels along its longest side, and out again.
struct MeshTimes {
  double in_ms = 0, out_ms = 0;
  size_t triangles_out = 0;  // two per quad
};
MeshTimes openvdb_mesh_through_volume(const std::vector<float>& points_xyz,
                                      const std::vector<unsigned>& triangles, int n);

}  // namespace kibori_bench
