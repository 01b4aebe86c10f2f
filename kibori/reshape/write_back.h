// SPDX-License-Identifier: MIT
// Writes a change of signed distances (node_band.h) into the spans of all three fields. The new
// sign of phi decides whether a node is inside, for all fields. Consider two neighbours whose signs
// differ, both before and after the change. The end between them moves by the same distance as the
// zero of phi. Therefore, an end that does not move keeps its bits, and the surface is not sampled
// again. Internal to `reshape`.
#pragma once

#include <array>
#include <vector>

#include <kibori/reshape/brush.h>
#include <kibori/reshape/node_band.h>
#include <kibori/reshape/ray_writer.h>

namespace kibori {

// Returns true if `touched` has too few nodes for this change. `touched` contains only nodes with
// |phi| < core. If a node changes sides, the normals of its new ends depend on nodes up to two
// steps away. `touched` must also contain those of them with |phi| < deepest.
bool changes_beyond(const NodeBand& band, const NodeValues& after,
                    const std::vector<NodeBlock>& touched, float core, float deepest, int threads);

// Writes changes of a band's nodes into the model from which the band was read. Keeps its memory.
class WriteBack {
 public:
  // Prepares changes of the nodes `touched`. None of them may be in the two outermost layers of the
  // box. `band` and `touched` must not change until the next begin(). `threads` is the number of
  // threads; results do not depend on it.
  void begin(const NodeBand& band, const std::vector<NodeBlock>& touched, int threads);
  // Returns the volume that write() would add minus the volume that it would remove [lattice
  // units^3]. `after` has the same indices as band.phi(). It may differ from band.phi() only at the
  // touched nodes. It must be set up to two nodes around them.
  double volume(const TriDexel& model, const NodeValues& after);
  // Like volume(), but computed from the nodes alone. It is wrong by a few percent, and takes a
  // fifth of the time.
  double rough_volume(const TriDexel& model, const NodeValues& after) const;
  // Writes the change into the model, and returns its effect. `after` is as in volume().
  Reshaped write(TriDexel& model, const NodeValues& after);

 private:
  void find_rays(const TriDexel& model, size_t axis);

  const NodeBand* band_ = nullptr;
  const std::vector<NodeBlock>* touched_ = nullptr;
  int threads_ = 1;
  NodeBox box_;                    // box of the touched nodes
  std::array<RayRanges, 3> rays_;  // rays through these nodes, for each axis of kAxes
  std::array<bool, 3> found_{};
};

}  // namespace kibori
