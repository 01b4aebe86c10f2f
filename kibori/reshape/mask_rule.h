// SPDX-License-Identifier: MIT
// Computes the new mask of an end under a mask brush.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/reshape/end_painter.h>

namespace kibori {

// The rule of one dab. The constructor reads the surface within the places and around them. The dab
// must not have changed the surface before.
class MaskRule {
 public:
  MaskRule(const TriDexel& model, const Brush& brush, const BrushPlaces& places);

  // Returns the mask that the brush aims for, from 0 (no mask) to 1 (fully masked).
  double wanted(const PaintedEnd& end) const;

 private:
  struct Near {
    Eigen::Vector3f at;  // [cells]
    float mask;
  };
  void read(const TriDexel& model, BrushPlaces places);
  // Calls f(near, distance) for the ends within reach_ of the point.
  template <class F>
  void for_near(const Vec3& at, F&& f) const;
  double mean_mask(const PaintedEnd& end) const;
  double hollowness(const PaintedEnd& end) const;

  const Brush& brush_;
  Vec3 plane_point_;  // [cells]
  double reach_ = 0;  // [cells]
  // near_ has the ends, sorted by cubes of side reach_. cubes_ has the range of each cube in near_.
  std::vector<Near> near_;
  std::unordered_map<uint64_t, std::pair<uint32_t, uint32_t>> cubes_;
};

}  // namespace kibori
