// SPDX-License-Identifier: MIT
// The workload of the step benchmark: a ball scrapes the top of a solid cube, half of it inside the
// cube, one cell per step.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

namespace kibori_bench {

struct Point {
  float x, y, z;  // ball centre; voxel (lattice node) i is at coordinate i
};

// A zigzag over the +z face of a cube of n nodes. Rows are `radius` apart, and a sub-cell wobble
// avoids lattice-aligned positions. jump_every > 0: after that many steps the ball jumps to another
// place.
inline std::vector<Point> scrape_path(int n, float radius, int steps, int jump_every = 0) {
  std::vector<Point> path;
  const float low = radius + 10, high = static_cast<float>(n) - radius - 10;
  float x = low, y = low, y_target = low;
  int direction = 1;
  unsigned random = 12345;
  const auto anywhere = [&] {
    random = random * 1664525u + 1013904223u;
    return low + (high - low) * static_cast<float>(random >> 8) / 16777216.0f;
  };
  for (int i = 0; i < steps; i++) {
    if (jump_every > 0 && i > 0 && i % jump_every == 0) {
      x = std::floor(anywhere());
      y = y_target = std::floor(anywhere());
    }
    const auto t = static_cast<float>(i);
    path.push_back({x + 0.31f, y + 0.3f * std::sin(0.11f * t),
                    static_cast<float>(n) - 0.5f + 0.8f * std::sin(0.05f * t)});
    if (y < y_target) {
      y += 1;
      continue;
    }
    const float next = x + static_cast<float>(direction);
    if (next > high || next < low) {
      direction = -direction;
      y_target = y + radius;
      y += 1;
    } else {
      x = next;
    }
  }
  return path;
}

struct StepTimes {
  std::vector<double> us;  // one per step
  double removed = 0;      // nodes
  double bytes = 0;        // of the model afterwards
};

inline double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const auto at = static_cast<size_t>(share * static_cast<double>(values.size()));
  return values[std::min(values.size() - 1, at)];
}
inline double median(const std::vector<double>& values) { return percentile(values, 0.5); }

inline double now_us() {
  return std::chrono::duration<double, std::micro>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace kibori_bench
