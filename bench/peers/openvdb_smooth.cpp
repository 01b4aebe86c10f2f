// SPDX-License-Identifier: MIT
#include "bench/peers/openvdb_smooth.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Clip.h>
#include <openvdb/tools/LevelSetFilter.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <tbb/global_control.h>

namespace kibori_bench {

using openvdb::Coord;
using openvdb::FloatGrid;

StepTimes openvdb_smooth_dabs(float ball, const std::vector<Point>& centres, float radius) {
  openvdb::initialize();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto grid = openvdb::tools::createLevelSetSphere<FloatGrid>(ball, openvdb::Vec3f(0), 1, 3);
  StepTimes times;
  for (const Point& centre : centres) {
    const openvdb::Vec3d c(static_cast<double>(centre.x), static_cast<double>(centre.y),
                           static_cast<double>(centre.z));
    const double reach = static_cast<double>(radius) + 6;
    const openvdb::CoordBBox box(Coord::floor(c - reach), Coord::ceil(c + reach));
    const auto part =
        openvdb::tools::clip(*grid, openvdb::BBoxd(box.min().asVec3d(), box.max().asVec3d()));
    part->setGridClass(openvdb::GRID_LEVEL_SET);
    FloatGrid mask(0);
    for (auto voxel = part->cbeginValueOn(); voxel; ++voxel) {
      if (!voxel.isVoxelValue()) continue;
      const double d = (voxel.getCoord().asVec3d() - c).length() / static_cast<double>(radius);
      const double inner = std::max(0.0, 1 - d * d);
      mask.tree().setValue(voxel.getCoord(), static_cast<float>(inner * inner));
    }
    const double start = now_us();
    openvdb::tools::LevelSetFilter<FloatGrid> filter(*part);
    filter.setGrainSize(0);
    filter.gaussian(1, &mask);
    times.us.push_back(now_us() - start);
  }
  return times;
}

}  // namespace kibori_bench
