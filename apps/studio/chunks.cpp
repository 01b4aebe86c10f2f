// SPDX-License-Identifier: MIT
#include "apps/studio/chunks.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace kibori::studio {
namespace {

constexpr double kSteps = 2048;  // per pitch

template <class T>
void put(std::vector<uint8_t>& to, T value) {
  const size_t at = to.size();
  to.resize(at + sizeof value);
  std::memcpy(to.data() + at, &value, sizeof value);
}

}  // namespace

void put_chunk(std::vector<uint8_t>& to, const SurfaceChunk& chunk, const Index3& at,
               const Lattice& lattice) {
  for (int i = 0; i < 3; i++) put(to, static_cast<int16_t>(at[i]));
  put(to, static_cast<uint32_t>(chunk.vertices.size()));
  put(to, static_cast<uint32_t>(chunk.triangles.size()));
  // `paint` holds the colour and the mask of a vertex.
  const bool painted = std::any_of(chunk.vertices.begin(), chunk.vertices.end(),
                                   [](const SurfaceVertex& v) { return v.paint != 0; });
  put(to, static_cast<uint16_t>(painted));
  for (const SurfaceVertex& v : chunk.vertices) {
    for (int i = 0; i < 3; i++) {
      const double cells =
          (static_cast<double>(v.position[static_cast<size_t>(i)]) - lattice.origin_mm[i]) /
          lattice.pitch_mm;
      const double step = std::round(cells * kSteps) - (kChunkCells * at[i] - 1) * kSteps;
      put(to, static_cast<uint16_t>(std::clamp(step, 0.0, 65535.0)));
    }
    for (const float n : v.normal)
      put(to, static_cast<int8_t>(std::lround(127 * std::clamp(n, -1.0f, 1.0f))));
    put(to, v.material);
  }
  for (const SurfaceTriangle& t : chunk.triangles)
    for (const uint32_t corner : t) put(to, static_cast<uint16_t>(corner));
  // A colour is 0xMMBBGGRR (color.h), so its bytes in memory are red, green, blue, and the mask.
  if (painted)
    for (const SurfaceVertex& v : chunk.vertices) put(to, v.paint);
}

}  // namespace kibori::studio
