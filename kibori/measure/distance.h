// SPDX-License-Identifier: MIT
// How far two surfaces are apart.
#pragma once

#include <cstdint>
#include <memory>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

// The triangles of a surface, to be asked for distances; the surface must outlive it.
class DistanceTree {
 public:
  explicit DistanceTree(const Surface& surface);
  ~DistanceTree();
  DistanceTree(const DistanceTree&) = delete;
  DistanceTree& operator=(const DistanceTree&) = delete;

  // False if there was not enough memory.
  bool good() const;
  // From a point to the nearest triangle [mm]. Any thread.
  double distance(const Vec3& point) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct Distance {  // [mm]
  double max = 0, rms = 0, mean = 0;
  Vec3 at = Vec3::Zero();  // where it is largest
};
// From `from` to `to`: over all vertices of `from` and about `samples` points spread evenly over
// its area (the maximum is over both, the means over the points alone). The same for any number of
// threads. Errors: a surface without triangles, not enough memory.
Result<Distance> distance_from_to(const Surface& from, const Surface& to, int64_t samples,
                                  int threads = 1);

struct TwoSided {
  Distance there, back;
  double max() const;
  double rms() const;
};
Result<TwoSided> two_sided_distance(const Surface& a, const Surface& b, int64_t samples,
                                    int threads = 1);

}  // namespace kibori
