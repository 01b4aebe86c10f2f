// SPDX-License-Identifier: MIT
#include <kibori/reshape/connected_nodes.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace kibori {
namespace {

// carry() looks for nodes of material up to kAround nodes away from the point that is kBelow
// [cells] below the surface. A sharp vertex is up to 1.5 cells from the nodes of its material.
constexpr double kBelow = 0.5;
constexpr int kAround = 2;

Vec3 place_of(const Index3& node) { return node.matrix().cast<double>().array() + 0.5; }

}  // namespace

ConnectedNodes::ConnectedNodes(const NodeBox& box, const std::vector<uint8_t>& inside,
                               const GrabReach& reach) {
  for (int d = 0; d < 3; d++) {
    box_.low[d] = static_cast<int>(std::floor(std::min(reach.from[d], reach.to[d]) - reach.radius));
    box_.high[d] =
        static_cast<int>(std::ceil(std::max(reach.from[d], reach.to[d]) + reach.radius)) + 1;
  }
  box_ = box_.within(box);
  if (box_.empty()) return;
  const size_t nodes = box_.stride(2) * static_cast<size_t>(box_.size()[2]);
  reached_.assign(nodes, 0);
  other_.assign(nodes, 0);
  // Marks all material within reach, and finds its node that is nearest to the start.
  double nearest = std::numeric_limits<double>::infinity();
  Index3 start = box_.low;
  for (int k = box_.low[2]; k < box_.high[2]; k++)
    for (int j = box_.low[1]; j < box_.high[1]; j++)
      for (int i = box_.low[0]; i < box_.high[0]; i++) {
        if (!inside[box.index(i, j, k)]) continue;
        const Index3 node(i, j, k);
        const Vec3 place = place_of(node);
        if (!reach.holds(place)) continue;
        other_[box_.index(i, j, k)] = 1;
        const double distance = (place - reach.from).squaredNorm();
        if (distance >= nearest) continue;
        nearest = distance;
        start = node;
      }
  if (!(nearest < reach.radius * reach.radius)) return;
  std::vector<Index3> open{start};
  const auto reach_node = [&](const Index3& node) {
    const size_t at = box_.index(node[0], node[1], node[2]);
    other_[at] = 0;
    reached_[at] = 1;
  };
  reach_node(start);
  while (!open.empty()) {
    const Index3 node = open.back();
    open.pop_back();
    for (int d = 0; d < 3; d++)
      for (const int side : {-1, 1}) {
        Index3 next = node;
        next[d] += side;
        if (!box_.holds({next, next + 1}) || !other_[box_.index(next[0], next[1], next[2])])
          continue;
        reach_node(next);
        open.push_back(next);
      }
  }
}

bool ConnectedNodes::carry(const Vec3& place, const Vec3& normal) const {
  if (reached_.empty()) return false;
  const Vec3 below = place - kBelow * normal;
  const Index3 middle = below.array().floor().cast<int>();
  double nearest = std::numeric_limits<double>::infinity();
  bool carries = false;
  for (int k = -kAround; k <= kAround; k++)
    for (int j = -kAround; j <= kAround; j++)
      for (int i = -kAround; i <= kAround; i++) {
        const Index3 node = middle + Index3(i, j, k);
        if (!box_.holds({node, node + 1})) continue;
        const size_t at = box_.index(node[0], node[1], node[2]);
        if (!reached_[at] && !other_[at]) continue;
        const double distance = (place_of(node) - below).squaredNorm();
        if (distance >= nearest) continue;
        nearest = distance;
        carries = reached_[at] != 0;
      }
  return carries;
}

}  // namespace kibori
