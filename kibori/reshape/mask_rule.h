// SPDX-License-Identifier: MIT
// Computes the mask of an end that a mask brush aims for.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/reshape/end_painter.h>

namespace kibori {

// For one dab. Reads the surface within the places and next to them, before the dab changes it.
class MaskRule {
 public:
  MaskRule(const TriDexel& model, const Brush& brush, const BrushPlaces& places);

  // The mask that the brush aims for, from 0 to 1 (fully masked).
  double wanted(const PaintedEnd& end) const;

 private:
  struct Near {
    Eigen::Vector3f at;  // [cells]
    float mask;
  };
  void read(const TriDexel& model, BrushPlaces places);
  // Calls f(near, distance) for the ends within reach.
  template <class F>
  void for_near(const Vec3& at, F&& f) const;
  double mean_mask(const PaintedEnd& end) const;
  double hollowness(const PaintedEnd& end) const;

  const Brush& brush_;
  Vec3 plane_point_;  // [cells]
  double reach_ = 0;  // [cells]
  // The ends in cubes of side reach_, and the range of each cube.
  std::vector<Near> near_;
  std::unordered_map<uint64_t, std::pair<uint32_t, uint32_t>> cubes_;
};

}  // namespace kibori
