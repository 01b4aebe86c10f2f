// SPDX-License-Identifier: MIT
// Encodes surface chunks for pages. See Chunks in protocol/messages.json.
#pragma once

#include <cstdint>
#include <vector>

#include <kibori/surface/surface.h>

namespace kibori::studio {

// Appends a chunk. Positions are rounded to 1/2048 of the pitch, for all chunks alike, so that
// neighbours fit together.
void put_chunk(std::vector<uint8_t>& to, const SurfaceChunk& chunk, const Index3& at,
               const Lattice& lattice);

}  // namespace kibori::studio
