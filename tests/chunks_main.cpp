// SPDX-License-Identifier: MIT
// Extracts all surface chunks of a document's current state, as the studio would send them. Usage:
// kibori_chunks FILE.kibori > CHUNKS
#include <cstdio>

#include <kibori/run/documents.h>
#include <kibori/surface/surface.h>

#include "apps/studio/chunks.h"

int main(int argc, char** argv) {
  using namespace kibori;
  if (argc != 2) return std::fprintf(stderr, "usage: kibori_chunks FILE.kibori\n"), 2;
  const auto model = document_model(argv[1]);
  if (!model) return std::fprintf(stderr, "%s\n", model.error().c_str()), 2;
  const Snapshot snapshot = model.value()->snapshot();
  const LiveSurface surface(snapshot, 1);
  const ChunkRange range = surface_chunks(snapshot.lattice);
  std::vector<uint8_t> bytes;
  for (int x = range.low.x(); x < range.high.x(); x++)
    for (int y = range.low.y(); y < range.high.y(); y++)
      for (int z = range.low.z(); z < range.high.z(); z++)
        if (const SurfaceChunk& chunk = surface.chunk({x, y, z}); !chunk.triangles.empty())
          studio::put_chunk(bytes, chunk, {x, y, z}, snapshot.lattice);
  return std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size() ? 0 : 1;
}
