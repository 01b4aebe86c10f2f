// SPDX-License-Identifier: MIT
// Encodes chunks (parts of the surface) for pages. See Chunks in protocol/messages.json.
#pragma once

#include <cstdint>
#include <vector>

#include <kibori/surface/surface.h>

namespace kibori::studio {

// Appends a chunk. All positions are rounded to one grid with the spacing 1/2048 of the pitch, so
// that neighbouring chunks fit together.
void put_chunk(std::vector<uint8_t>& to, const SurfaceChunk& chunk, const Index3& at,
               const Lattice& lattice);

}  // namespace kibori::studio
