// SPDX-License-Identifier: MIT
// A change of signed distances (node_band.h) into the spans of all three fields. The new sign
// decides every node, for all fields. An end between two nodes that have a sign change before and
// after moves by the difference of the two zeros, so what did not change stays, bit for bit, and
// nothing is sampled twice. Internal to `reshape`.
#pragma once

#include <array>
#include <vector>

#include <kibori/reshape/brush.h>
#include <kibori/reshape/node_band.h>
#include <kibori/reshape/ray_writer.h>

namespace kibori {

// Writes `after` (by indices as of band.phi()) into the model that the band was read from. It may
// differ at the nodes `touched` only, none of the box's two outermost layers, and is read as far as
// two nodes beside them. The result does not depend on `threads`.
Reshaped write_back(TriDexel& model, const NodeBand& band, const std::vector<float>& after,
                    const std::vector<NodeBlock>& touched, int threads);

// Whether a node that changes sides has others beside it, within what its ends' slopes reach, that
// are core to `deepest` deep: which `touched` leaves out, and a change must not.
bool changes_beyond(const NodeBand& band, const std::vector<float>& after,
                    const std::vector<NodeBlock>& touched, float core, float deepest);

// What write_back would do, for several changes of the same nodes.
class VolumeChange {
 public:
  VolumeChange(const TriDexel& model, const NodeBand& band, const std::vector<NodeBlock>& touched,
               int threads);
  // The volume [lattice units^3] that it would add (less what it would remove).
  double operator()(const std::vector<float>& after) const;

 private:
  const TriDexel& model_;
  const NodeBand& band_;
  std::array<RayRanges, 3> rays_;  // by axis
  int threads_;
};

}  // namespace kibori
