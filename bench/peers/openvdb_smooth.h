// SPDX-License-Identifier: MIT
// The peer for smoothing: OpenVDB's LevelSetFilter.
#pragma once

#include "bench/workload.h"

namespace kibori_bench {

// Smooths a level set, of half-width 3, of a ball with radius `ball` [voxels]. Each dab copies the
// brush's box with a border of the filter's reach, which is not timed. LevelSetFilter::gaussian
// then smooths the box under an alpha mask of the brush's falloff, on one thread. Its Gaussian of
// width 1 is four box filters: sigma = 1.6 voxels. The next larger one, sigma = 2.8, takes longer.
StepTimes openvdb_smooth_dabs(float ball, const std::vector<Point>& centres, float radius);

}  // namespace kibori_bench
