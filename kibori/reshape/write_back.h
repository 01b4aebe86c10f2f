// SPDX-License-Identifier: MIT
// Writes a change of signed distances (node_band.h) into the spans of all three fields. The new
// sign decides every node, for all fields. If the sign differs between two nodes before and after
// the change, the end between them moves as far as the zero of phi. Therefore, ends that do not
// move keep their bits, and no surface is sampled again. Internal to `reshape`.
#pragma once

#include <array>
#include <vector>

#include <kibori/reshape/brush.h>
#include <kibori/reshape/node_band.h>
#include <kibori/reshape/ray_writer.h>

namespace kibori {

// True if `touched` is too small for the change. `touched` contains only nodes with |phi| < core.
// If a node changes sides, the normals of its new ends depend on nodes up to two steps away. The
// change must also include those with |phi| < deepest.
bool changes_beyond(const NodeBand& band, const NodeValues& after,
                    const std::vector<NodeBlock>& touched, float core, float deepest, int threads);

// Writes changes of a band's nodes into the model that the band was read from. Keeps its memory.
class WriteBack {
 public:
  // Prepares changes of the nodes `touched`. None may be in the box's two outermost layers. `band`
  // and `touched` must not change until the next begin(). Results do not depend on `threads`.
  void begin(const NodeBand& band, const std::vector<NodeBlock>& touched, int threads);
  // The volume [lattice units^3] that write() would add minus what it would remove. `after`, here
  // and in write(), has the indices of band.phi(), and may differ from it only at the touched
  // nodes. It is read up to two nodes around them.
  double volume(const TriDexel& model, const NodeValues& after);
  // The same within a few percent, from the nodes alone, in a fifth of the time.
  double rough_volume(const TriDexel& model, const NodeValues& after) const;
  Reshaped write(TriDexel& model, const NodeValues& after);

 private:
  void find_rays(const TriDexel& model, size_t axis);

  const NodeBand* band_ = nullptr;
  const std::vector<NodeBlock>* touched_ = nullptr;
  int threads_ = 1;
  NodeBox box_;                    // of the touched nodes
  std::array<RayRanges, 3> rays_;  // through them, per axis of kAxes
  std::array<bool, 3> found_{};
};

}  // namespace kibori
