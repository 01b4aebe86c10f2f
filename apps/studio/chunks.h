// SPDX-License-Identifier: MIT
// Surface chunks on their way to a page: see Chunks in protocol/messages.json.
#pragma once

#include <cstdint>
#include <vector>

#include <kibori/surface/surface.h>

namespace kibori::studio {

// Appends a chunk. Positions are rounded to 1/2048 of the pitch, all chunks' alike, so that they
// fit.
void put_chunk(std::vector<uint8_t>& to, const SurfaceChunk& chunk, const Index3& at,
               const Lattice& lattice);

}  // namespace kibori::studio
