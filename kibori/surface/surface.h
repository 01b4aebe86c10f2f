// SPDX-License-Identifier: MIT
// The surface of a model as triangles, by dual contouring of the dexels' exact ends and normals.
//
// This holds for every model within kMaxFromOrigin pitches of the origin: The surface is a closed,
// oriented two-manifold. Every directed edge occurs once, and its reverse once. Each vertex has one
// fan of triangles. No triangle is degenerate, and no two vertices share a float32 position.
// Material that is thinner than a cell and passes between the lattice nodes is not seen. Edges stay
// sharp where two faces meet at more than 25 degrees.
//
// Cells are between lattice nodes. There is one more cell than nodes along each axis, and the
// outermost cells reach beyond the lattice. A chunk has 16 x 16 x 16 cells. Its surface depends on
// the snapshot alone. Therefore, chunks can be made in any order and on any thread, and rebuilt
// after an edit. They fit bit for bit.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

inline constexpr int kChunkCells = 16;

// Number of chunks along each axis.
Index3 surface_chunks(const Lattice& lattice);

// The surface of one chunk. The chunk's own vertices come first. Vertices of the next chunks' cells
// that its triangles use follow. They equal the vertices of those chunks to the bit.
struct SurfaceChunk {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> triangles;
  uint32_t own = 0;  // number of own vertices
  // Per vertex: z + 17 (x + 17 y) of its cell in the chunk, times 4, plus its sheet. Own ones
  // ascend. Vertices in the middle of a face come last, with kNoCell.
  std::vector<uint32_t> cell;
};
inline constexpr uint32_t kNoCell = ~0u;

// The surface of one chunk. `chunk` must be below surface_chunks().
SurfaceChunk extract_chunk(const Snapshot& model, const Index3& chunk);

// The chunks whose surface may differ between two snapshots of one model, in ascending order. The
// search compares what the snapshots do not share, so its cost is that of the edits between them.
std::vector<Index3> changed_chunks(const Snapshot& before, const Snapshot& now);

// A surface that follows its model. It reuses its memory between updates.
class LiveSurface {
 public:
  explicit LiveSurface(const Snapshot& model, int threads = 1);
  ~LiveSurface();
  LiveSurface(LiveSurface&&) noexcept;
  LiveSurface& operator=(LiveSurface&&) noexcept;

  // Rebuilds the chunks that changed since the last snapshot, and returns their indices. The model
  // may change during the call.
  const std::vector<Index3>& update(const Snapshot& now);
  // The chunk's surface; empty if it has none.
  const SurfaceChunk& chunk(const Index3& at) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Sends the whole surface chunk by chunk. It uses up to `threads` threads, and the result is the
// same for any number. It needs memory for a few layers of chunks, for a model of any size.
void stream_surface(const Snapshot& model, int threads, const SurfaceSink& sink);

// Returns the whole surface at once.
Surface extract_surface(const Snapshot& model, int threads = 1);

}  // namespace kibori
