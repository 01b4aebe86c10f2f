// SPDX-License-Identifier: MIT
// The lattice nodes within reach of a grab that a path through material connects with the grabbed
// place. Internal.
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
  // Starts at the node of material nearest to `reach.from`. A path has steps to the six neighbours.
  // `inside`: 1 for a node of material, per node of `box`. If there is no material within reach, no
  // node is connected.
  ConnectedNodes(const NodeBox& box, const std::vector<uint8_t>& inside, const GrabReach& reach);

  // True if the material below this place of the surface is connected. `normal` is the outward
  // normal of the surface.
  bool carry(const Vec3& place, const Vec3& normal) const;

 private:
  NodeBox box_;                   // the nodes within reach
  std::vector<uint8_t> reached_;  // per node of box_
  std::vector<uint8_t> other_;    // material that is not connected, per node of box_
};

}  // namespace kibori
