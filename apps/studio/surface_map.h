// SPDX-License-Identifier: MIT
// A map shows properties of a body as colours on its surface, and as numbers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <kibori/body/bodies.h>
#include <kibori/document/document.h>
#include <kibori/surface/surface.h>

namespace kibori::studio {

// The map that one page shows.
class SurfaceMap {
 public:
  virtual ~SurfaceMap() = default;

  virtual BodyId body() const = 0;
  // Returns true if the map is still valid for these bodies at this step.
  virtual bool is_of(const kibori::BodyList& bodies, BodyId worked_on, StepId step) const = 0;
  // Colours a chunk, and stores the chunk's numbers.
  virtual SurfaceChunk paint(SurfaceChunk chunk, const Index3& at) = 0;
  // Returns the numbers of all coloured chunks as a message. `volume_mm3` is the current volume of
  // the body.
  virtual std::vector<uint8_t> message(double volume_mm3) const = 0;
};

// Orders chunks by their positions.
struct ChunkOrder {
  bool operator()(const Index3& a, const Index3& b) const {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  }
};

}  // namespace kibori::studio
