// SPDX-License-Identifier: MIT
// Finds the nodes of material that a grab moves (warp.h: grab_connected and hook). These nodes are
// within the reach of the grab, and a path through material connects them with the grabbed place.
// Internal to `reshape`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <kibori/geometry/vec.h>
#include <kibori/reshape/node_band.h>
#include <kibori/reshape/warp_map.h>

namespace kibori {

class ConnectedNodes {
 public:
  // Starts at the node of material that is nearest to `reach.from`. A path has steps to the six
  // neighbours of a node. `inside` has one element per node of `box`: 1 for material, otherwise 0.
  // If there is no material within the reach, no node is connected.
  ConnectedNodes(const NodeBox& box, const std::vector<uint8_t>& inside, const GrabReach& reach);

  // Returns true if the material below the surface at `place` is connected. `normal` is the outward
  // normal of the surface.
  bool carry(const Vec3& place, const Vec3& normal) const;

 private:
  NodeBox box_;                   // the nodes within the reach
  std::vector<uint8_t> reached_;  // for each node of box_: 1 if connected
  std::vector<uint8_t> other_;    // for each node of box_: 1 for material that is not connected
};

}  // namespace kibori
