// SPDX-License-Identifier: MIT
#include "apps/studio/session/ray_box.h"

#include <algorithm>
#include <cmath>

namespace kibori {
namespace {

// The nodes begin <= k < end of a ray.
struct NodeRun {
  int u, v, begin, end;
};

// Nodes are at k + 1/2. A span contains those in [in, out).
int first_node(double depth) { return static_cast<int>(std::ceil(depth - 0.5)); }

// Chooses the rays of the cube whose indices are multiples of `every`.
void choose_rays(RayBox& box, int every) {
  const auto up = [&](int first) {
    const int beyond = (first % every + every) % every;
    return beyond == 0 ? first : first + every - beyond;
  };
  const auto count = [&](int first, int last) {
    return last < up(first) ? 0 : (last - up(first)) / every + 1;
  };
  box.every = every;
  box.u = up(box.first_u);
  box.v = up(box.first_v);
  box.columns = count(box.first_u, box.last_u);
  box.rows = count(box.first_v, box.last_v);
  if (box.low >= box.high || box.columns == 0 || box.rows == 0)
    box.u = box.v = box.columns = box.rows = 0;
}

// Calls f(u, v) for the rays of the box. u changes fastest.
template <class F>
void for_rays(const RayBox& box, F&& f) {
  for (int row = 0; row < box.rows; row++)
    for (int column = 0; column < box.columns; column++)
      f(box.u + column * box.every, box.v + row * box.every);
}

}  // namespace

RayBox ray_box(const Lattice& lattice, Axis axis, const Vec3& centre_mm, double radius_mm,
               int every) {
  const Vec3 centre = lattice.to_lattice(centre_mm).units;
  const double radius = radius_mm / lattice.pitch_mm;
  // The node indices along an axis that are inside the cube and the lattice. A far cube has none.
  const auto indices = [&](int index) {
    const double low = lattice.low()[index], high = lattice.high()[index];
    const double first = std::ceil(std::clamp(centre[index] - radius - 0.5, low, high));
    const double last = std::floor(std::clamp(centre[index] + radius - 0.5, low - 1, high - 1));
    return std::array<int, 2>{static_cast<int>(first), static_cast<int>(last)};
  };
  RayBox box;
  box.axis = axis;
  const int depth = depth_index(axis);
  const double begin = lattice.low()[depth], end = lattice.high()[depth];
  box.low = std::clamp(centre[depth] - radius, begin, end);
  box.high = std::clamp(centre[depth] + radius, begin, end);
  const auto [u0, u1] = indices(u_index(axis));
  const auto [v0, v1] = indices(v_index(axis));
  box.first_u = u0, box.last_u = u1, box.first_v = v0, box.last_v = v1;
  for (choose_rays(box, every); std::max(box.columns, box.rows) > kMaxBoxRays;)
    choose_rays(box, 2 * box.every);
  return box;
}

RayBox finer(const RayBox& box) {
  RayBox more = box;
  choose_rays(more, (box.every + 3) / 4);
  return more;
}

std::vector<std::vector<Span>> spans_in(const RayBox& box, const Snapshot& snapshot) {
  std::vector<std::vector<Span>> rays;
  for_rays(box, [&](int u, int v) {
    std::vector<Span>& spans = rays.emplace_back();
    snapshot.field(box.axis).for_spans(u, v, [&](const Span& span) {
      if (span.in < box.high && span.out > box.low && spans.size() < kMaxBoxSpans)
        spans.push_back(span);
    });
  });
  return rays;
}

VanishedNodes vanished_in(const RayBox& box, const Snapshot& before, const Snapshot& now) {
  const int low = first_node(box.low), high = first_node(box.high);
  std::vector<NodeRun> gone;
  std::vector<std::array<int, 2>> left;  // nodes of the ray that are in the material now
  VanishedNodes result;
  for_rays(box, [&](int u, int v) {
    // One of the two may have a larger lattice.
    if (!before.field(box.axis).has_ray(u, v) || !now.field(box.axis).has_ray(u, v)) return;
    left.clear();
    now.field(box.axis).for_spans(u, v, [&](const Span& span) {
      left.push_back(
          {first_node(static_cast<double>(span.in)), first_node(static_cast<double>(span.out))});
    });
    size_t next = 0;
    before.field(box.axis).for_spans(u, v, [&](const Span& span) {
      int at = std::max(low, first_node(static_cast<double>(span.in)));
      const int end = std::min(high, first_node(static_cast<double>(span.out)));
      while (next < left.size() && left[next][1] <= at) next++;
      for (size_t i = next; at < end; i++) {
        const int until = i < left.size() ? std::min(left[i][0], end) : end;
        if (at < until) {
          gone.push_back({u, v, at, until});
          result.count += static_cast<size_t>(until - at);
        }
        if (i >= left.size()) break;
        at = std::max(at, left[i][1]);
      }
    });
  });
  const size_t step = (result.count + kMaxVanishedNodes - 1) / kMaxVanishedNodes;
  size_t passed = 0;  // nodes of the runs so far; every step-th one is listed
  for (const NodeRun& run : gone) {
    const auto length = static_cast<size_t>(run.end - run.begin);
    for (size_t k = (step - passed % step) % step; k < length; k += step) {
      std::array<int16_t, 3> node{};
      node[static_cast<size_t>(depth_index(box.axis))] =
          static_cast<int16_t>(run.begin + static_cast<int>(k));
      node[static_cast<size_t>(u_index(box.axis))] = static_cast<int16_t>(run.u);
      node[static_cast<size_t>(v_index(box.axis))] = static_cast<int16_t>(run.v);
      result.nodes.push_back(node);
    }
    passed += length;
  }
  return result;
}

}  // namespace kibori
