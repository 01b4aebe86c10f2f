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

// Whether a node that changes sides has others beside it, within what its ends' slopes reach, that
// are core to `deepest` deep: which `touched` leaves out, and a change must not.
bool changes_beyond(const NodeBand& band, const NodeValues& after,
                    const std::vector<NodeBlock>& touched, float core, float deepest, int threads);

// Writes changes of a band's nodes into the model that the band was read from; keeps its memory.
class WriteBack {
 public:
  // Changes of the nodes `touched`, none of the box's two outermost layers. Both arguments stay as
  // they are until the next begin(). Results do not depend on `threads`.
  void begin(const NodeBand& band, const std::vector<NodeBlock>& touched, int threads);
  // The volume [lattice units^3] that write() would add (less what it would remove). `after`, here
  // and there: by indices as of band.phi(), from which it may differ at the touched nodes only; it
  // is read as far as two nodes beside them.
  double volume(const TriDexel& model, const NodeValues& after);
  // The same within a few percent, from the nodes alone: in a fifth of the time.
  double rough_volume(const TriDexel& model, const NodeValues& after) const;
  Reshaped write(TriDexel& model, const NodeValues& after);

 private:
  void find_rays(const TriDexel& model, size_t axis);

  const NodeBand* band_ = nullptr;
  const std::vector<NodeBlock>* touched_ = nullptr;
  int threads_ = 1;
  NodeBox box_;                    // of the touched nodes
  std::array<RayRanges, 3> rays_;  // of kAxes, through them
  std::array<bool, 3> found_{};
};

}  // namespace kibori
