// SPDX-License-Identifier: MIT
// The peer of smoothing: OpenVDB's LevelSetFilter.
#pragma once

#include "bench/workload.h"

namespace kibori_bench {

// A level set of a ball [voxels] of half-width 3. Each dab cuts the brush's box out of it (and a
// border of the filter's reach, not timed), and smooths that by LevelSetFilter::gaussian under an
// alpha mask of the brush's falloff, with one thread. Its Gaussian of width 1 is four box filters:
// sigma = 1.6 voxels; the next, 2.8, takes longer.
StepTimes openvdb_smooth_dabs(float ball, const std::vector<Point>& centres, float radius);

}  // namespace kibori_bench
