// SPDX-License-Identifier: MIT
// Something that is told of a body by the colours of its surface, and in numbers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <kibori/body/bodies.h>
#include <kibori/document/document.h>
#include <kibori/surface/surface.h>

namespace kibori::studio {

// Of one page that looks at it.
class SurfaceMap {
 public:
  virtual ~SurfaceMap() = default;

  virtual BodyId body() const = 0;
  // Whether it is still of these bodies, as of that step.
  virtual bool is_of(const kibori::Bodies& bodies, BodyId worked_on, StepId step) const = 0;
  // The chunk in colours; its numbers are kept.
  virtual SurfaceChunk paint(SurfaceChunk chunk, const Index3& at) = 0;
  // The numbers of all chunks that were painted, as a message. `volume_mm3`: of the body now.
  virtual std::vector<uint8_t> said(double volume_mm3) const = 0;
};

// Orders chunks by their places.
struct ChunkOrder {
  bool operator()(const Index3& a, const Index3& b) const {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  }
};

}  // namespace kibori::studio
