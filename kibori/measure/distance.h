// SPDX-License-Identifier: MIT
// Distances between two surfaces.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// A search tree over the triangles of a surface, which must outlive the tree.
class DistanceTree {
 public:
  explicit DistanceTree(const Surface& surface);
  ~DistanceTree();
  DistanceTree(const DistanceTree&) = delete;
  DistanceTree& operator=(const DistanceTree&) = delete;

  // False if the memory was not enough to build the tree.
  bool good() const;
  // Returns the distance from a point to the nearest triangle [mm]. Any thread.
  double distance(const Vec3& point) const;
  // The same with a sign: it is negative if the point is behind the nearest triangle. Therefore, it
  // is negative inside a closed surface whose triangles face outwards. Any thread.
  double signed_distance(const Vec3& point) const;

 private:
  struct State;
  struct Search;
  std::unique_ptr<State> state_;
};

struct Distance {  // [mm]
  double max = 0, rms = 0, mean = 0;
  Vec3 at = Vec3::Zero();  // the point with the largest distance
};
// Measures the distances from points of `from` to the nearest points of `to`. The points of `from`
// are its used vertices, and about `samples` points that are spread evenly over its area. The
// maximum is over all points. The means are over the spread points only. The result does not depend
// on `threads`. Errors: a surface without triangles; not enough memory.
Result<Distance> distance_from_to(const Surface& from, const Surface& to, int64_t samples,
                                  int threads = 1);

// How a surface differs from a closed surface, its target [mm]. Outside the target, values are
// positive.
struct Deviation {
  double max = 0, min = 0;  // largest excess; deepest gouge (negative); 0 if there is none
  Vec3 max_at = Vec3::Zero(), min_at = Vec3::Zero();
  double mean = 0, rms = 0;
  std::vector<float> of_vertices;  // for each vertex of the surface; 0 if no triangle uses it
};
// Measures the deviation of `surface` from `target`, at the same points of `surface` as
// distance_from_to. Errors: those of distance_from_to; a target that is not closed.
Result<Deviation> deviation_from(const Surface& surface, const Surface& target, int64_t samples,
                                 int threads = 1);

// Distances between two surfaces a and b: from a to b (there), and from b to a (back).
struct TwoSided {
  Distance there, back;
  double max() const;
  double rms() const;
};
Result<TwoSided> two_sided_distance(const Surface& a, const Surface& b, int64_t samples,
                                    int threads = 1);

}  // namespace kibori
