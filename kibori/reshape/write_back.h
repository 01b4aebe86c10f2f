// SPDX-License-Identifier: MIT
// A change of signed distances (node_band.h) into the spans of all three fields. The new sign
// decides every node, for all fields. An end between two nodes that have a sign change before and
// after moves by the difference of the two zeros, so what did not change stays, bit for bit, and
// nothing is sampled twice. Internal to `reshape`.
#pragma once

#include <vector>

#include <kibori/reshape/brush.h>
#include <kibori/reshape/node_band.h>

namespace kibori {

// Writes `after` (as long as band.phi()) into the model that the band was read from. It may differ
// at the nodes `touched` only, none of the box's two outermost layers.
Reshaped write_back(TriDexel& model, const NodeBand& band, const std::vector<float>& after,
                    const std::vector<uint32_t>& touched);

// The volume [lattice units^3] that write_back would add (less what it would remove), and no
// write.
double volume_change(const TriDexel& model, const NodeBand& band, const std::vector<float>& after,
                     const std::vector<uint32_t>& touched);

}  // namespace kibori
